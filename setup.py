"""The readme that a package index shows: README.md, whose links lead to files of the repository.

Where ``[project.urls]`` in ``pyproject.toml`` has a ``Source``, the address of the repository,
links lead there. Without one the text names the file in the place of a link, and pictures are
left out.
"""

import re
import tomllib
from pathlib import Path

from setuptools import setup

HERE = Path(__file__).parent
LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?:|#)([^)]+)\)")
"""A picture or a link to a file of the repository: its mark, its text, its target."""


def absolute(readme: str, source: str) -> str:
    """The text without relative links; ``source`` is the address of the repository, or empty."""

    def replaced(link: re.Match[str]) -> str:
        mark, text, target = link.groups()
        if source:
            return f"{mark}[{text}]({source.rstrip('/')}/{'raw' if mark else 'blob'}/main/{target})"
        return "" if mark else text if target == text else f"{text} ({target})"

    return LINK.sub(replaced, readme)


if __name__ == "__main__":
    project = tomllib.loads((HERE / "pyproject.toml").read_text("utf-8"))["project"]
    setup(
        long_description=absolute(
            (HERE / "README.md").read_text("utf-8"), project.get("urls", {}).get("Source", "")
        ),
        long_description_content_type="text/markdown",
    )
