"""Modules of the folder of tools, which is no package."""

import sys
from importlib import import_module
from pathlib import Path

TOOLS = Path(__file__).parents[1] / "tools"


def tool(name):
    """A module by its name."""
    sys.path.insert(0, str(TOOLS))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(TOOLS))
