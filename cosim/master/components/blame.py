"""Which line of a user's Python file an exception comes from."""

from __future__ import annotations

import sysconfig
import traceback
from pathlib import Path
from types import CodeType
from typing import Any

from cosim.scenario.source.find import shown_name

_OURS = Path(__file__).resolve().parents[2]
_INSTALLED = tuple(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "purelib"))


def told(error: BaseException) -> str:
    """The exception's type and text, and the innermost line of the user's own that led to it."""
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        where = f"{shown_name(Path(error.filename))}:{error.lineno}:{error.offset or 1}"
        return f"{type(error).__name__}: {error.msg} ({where})"
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frames = [f for f in traceback.extract_tb(error.__traceback__) if _rank(f.filename) > 0]
    if not frames:
        return text
    own = max(_rank(frame.filename) for frame in frames)
    last = [frame for frame in frames if _rank(frame.filename) == own][-1]
    return f"{text} ({shown_name(Path(last.filename))}:{last.lineno}, in {last.name})"


def written_at(member: Any) -> str:
    """`` (file:line)`` of a property or function; empty for what was not written in Python."""
    function = getattr(member, "fget", None) or member
    code = getattr(function, "__code__", None)
    if not isinstance(code, CodeType):
        return ""
    return f" ({shown_name(Path(code.co_filename))}:{code.co_firstlineno})"


def _rank(filename: str) -> int:
    """2 for a file of the user's, 1 for one of an installed package, 0 for what is no file."""
    path = Path(filename)
    if filename.startswith("<") or path.resolve().is_relative_to(_OURS):
        return 0
    return 1 if any(path.resolve().is_relative_to(folder) for folder in _INSTALLED) else 2
