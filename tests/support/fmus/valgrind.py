"""Programs under valgrind's memcheck, and what it has to say of the code that is ours.

Python, NumPy and the loader read what was never written, and keep what they were given; so a
complaint is ours where a frame of its stacks, of its origin too, lies in a file of a folder.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

MEMCHECK = ("--error-limit=no", "--num-callers=30", "--track-origins=yes", "--xml=yes")
VALGRIND = shutil.which("valgrind")


def complaints(
    command: Sequence[str | Path], ours: Path, *, cwd: Path | None = None, leaks: bool = False
) -> tuple[list[str], subprocess.CompletedProcess[str]]:
    """What is wrong in files below ``ours``, a sentence each, and the finished program."""
    file = ours / "memcheck.xml"
    assert VALGRIND is not None
    checked = "full" if leaks else "no"
    watching = [VALGRIND, *MEMCHECK, f"--leak-check={checked}", f"--xml-file={file}"]
    done = subprocess.run(
        [*watching, *map(str, command)],
        capture_output=True,
        text=True,
        check=False,
        cwd=cwd,
        # Python's own allocator would hide where a block ends.
        env=os.environ | {"PYTHONMALLOC": "malloc"},
    )
    return list(_found(file, ours.resolve())), done


def _found(file: Path, ours: Path) -> Iterator[str]:
    for error in ElementTree.parse(file).getroot().iter("error"):
        frames = list(error.iter("frame"))
        if any(Path(frame.findtext("obj", "/")).is_relative_to(ours) for frame in frames):
            what = error.findtext("what") or error.findtext("xwhat/text") or "?"
            places = (
                f"{f.findtext('fn')} ({f.findtext('file')}:{f.findtext('line')})" for f in frames
            )
            yield f"{what}: {', '.join(places)}"
