"""Running a file or a module that somebody else wrote, and saying in one line how it failed."""

from __future__ import annotations

import sys
import tokenize
import traceback
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from voronec.errors import DefinitionError, VoronecError, file_errors


def run_file(path: Path) -> dict[str, Any]:
    """The names that a Python file defines; ``DefinitionError`` where it fails, with the line."""
    code = _compile(path)
    module = ModuleType(f"voronec_file_{path.stem}")
    module.__file__ = str(path)
    # What the file's classes look themselves up by, and where its neighbours are found.
    sys.modules[module.__name__] = module
    search = list(sys.path)
    sys.path.append(str(path.resolve().parent))
    try:
        exec(code, module.__dict__)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise DefinitionError(failure(error, str(path))) from error
    finally:
        sys.path[:] = search
        sys.modules.pop(module.__name__, None)
    return module.__dict__


def failure(error: BaseException, near: str) -> str:
    """One line for an error in somebody's code: the file, the line in it, what happened.

    ``near`` is the path of that file or folder: of the traceback, the last line inside it is told.
    """
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}, line {error.lineno}: {error.msg}"
    what = " ".join(str(error).split())
    if not isinstance(error, VoronecError):
        what = type(error).__name__ + (f": {what}" if what else "")
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename.startswith(near)]
    return f"{frames[-1].filename}, line {frames[-1].lineno}: {what}" if frames else what


def _compile(path: Path) -> CodeType:
    try:
        with file_errors(path, "a Python file"), tokenize.open(path) as stream:
            source = stream.read()
        return compile(source, str(path), "exec")
    except SyntaxError as error:
        line = f", line {error.lineno}" if error.lineno else ""
        raise DefinitionError(f"{path}{line}: {error.msg}; correct it") from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise DefinitionError(f"'{path}' is not a Python file: {error}") from None
