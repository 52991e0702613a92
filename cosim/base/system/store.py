"""Results that took long, kept in a folder of the user's cache: never trusted, always replaceable.

A file holds plain values (numbers, texts, bytes, lists, tuples, dictionaries) behind a digest of
what follows. Whatever is wrong with it, it counts as absent; where nothing can be written, nothing
is kept.
"""

from __future__ import annotations

import hashlib
import marshal
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

_MAGIC = f"cohaptic store 1 {sys.implementation.cache_tag} {marshal.version}\n".encode()
_DIGEST_BYTES = 32


def recall(file: Path) -> Any | None:
    """What ``keep`` put there; ``None`` where there is nothing, or not all of it."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    start = len(_MAGIC) + _DIGEST_BYTES
    body = content[start:]
    if content[:start] != _MAGIC + hashlib.sha256(body).digest():
        return None
    return marshal.loads(body)


def keep(file: Path, content: Any) -> None:
    """Keep plain values for a later ``recall``; another process may do the same at that time."""
    body = marshal.dumps(content)
    scratch = file.with_name(f"{file.name}.{os.getpid()}")
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            scratch.write_bytes(_MAGIC + hashlib.sha256(body).digest() + body)
            scratch.replace(file)
        finally:
            scratch.unlink(missing_ok=True)
