"""The pre-shared key in its file, and what a handshake derives from it (RFC 5869)."""

from __future__ import annotations

import base64
import binascii
import os
import secrets
import stat
from dataclasses import dataclass
from pathlib import Path

from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF

from cosim.base.errors import InputError
from cosim.link.wire.packet import VERSION

KEY_SIZE = 32
_PREFIX = "cohaptic-key-1 "


class PreSharedKey:
    """The secret that both stations hold; never shown, not even by ``repr``."""

    __slots__ = ("_secret",)

    def __init__(self, secret: bytes) -> None:
        if len(secret) != KEY_SIZE:
            message = f"a key has {KEY_SIZE} bytes, this one has {len(secret)}"
            raise InputError(message)
        self._secret = secret

    def __repr__(self) -> str:
        return "PreSharedKey(...)"

    def derive(self, purpose: str, *, context: bytes = b"") -> bytes:
        """A 32-byte key for one purpose; other purposes or contexts give unrelated keys."""
        info = join(b"cohaptic link", bytes([VERSION]), purpose.encode(), context)
        return HKDF(SHA256(), KEY_SIZE, None, info).derive(self._secret)


NO_KEY = PreSharedKey(bytes(KEY_SIZE))
"""Stands in where no key is given; everybody knows it, so it is good for loopback alone."""


@dataclass(frozen=True, slots=True)
class SessionKeys:
    """What one session seals and opens with; ``session`` is public and names it in the header."""

    session: int
    outgoing: bytes
    incoming: bytes

    def __repr__(self) -> str:
        return f"SessionKeys(session={self.session:#018x})"


def create_key_file(path: Path) -> None:
    """Write a new random key, readable by its owner alone.

    Raises:
        InputError: the file exists, or cannot be written.
    """
    text = _PREFIX + base64.b64encode(secrets.token_bytes(KEY_SIZE)).decode() + "\n"
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        message = f"{path} exists; a key is never overwritten. Choose another name or delete it"
        raise InputError(message) from None
    except OSError as error:
        message = f"{path} cannot be written: {error.strerror}"
        raise InputError(message) from None
    with os.fdopen(descriptor, "w", encoding="ascii") as file:
        file.write(text)


def read_key_file(path: Path) -> PreSharedKey:
    """The key in a file made by ``cohaptic keygen``.

    Raises:
        InputError: no such file, not a key, or others may read or write it.
    """
    try:
        # Not to wait for a writer where the path is a pipe.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(descriptor, "rb") as file:
            # The open file is examined, not the path: it cannot be swapped in between.
            _refuse_shared(path, os.fstat(file.fileno()))
            content = file.read(4096)
    except OSError as error:
        message = f"the key file {path} cannot be read: {error.strerror}"
        raise InputError(message) from None
    prefix, _, text = content.partition(b" ")
    try:
        secret = base64.b64decode(text.strip(), validate=True)
    except binascii.Error:
        secret = b""
    if prefix != _PREFIX.strip().encode() or len(secret) != KEY_SIZE:
        message = f"{path} is not a key; make one with 'cohaptic keygen {path.name}'"
        raise InputError(message)
    if secret == bytes(KEY_SIZE):
        message = (
            f"the key in {path} is all zero, which everybody knows; make one with 'cohaptic keygen'"
        )
        raise InputError(message)
    return PreSharedKey(secret)


def _refuse_shared(path: Path, status: os.stat_result) -> None:
    if not stat.S_ISREG(status.st_mode):
        message = f"the key file {path} is not a regular file"
        raise InputError(message)
    if os.name == "posix" and status.st_uid not in {os.geteuid(), 0}:
        message = (
            f"the key file {path} belongs to somebody else, who knows it and can change it; "
            "copy it to a file of your own, or make a new key"
        )
        raise InputError(message)
    # Windows has no such mode bits: there the folder's access list has to keep others out.
    if os.name == "posix" and status.st_mode & 0o077:
        mode = stat.S_IMODE(status.st_mode)
        message = (
            f"the key file {path} can be read or written by others (mode {mode:04o}); "
            f"run 'chmod 600 {path}', and make a new key if anybody may have seen it"
        )
        raise InputError(message)


def join(*parts: bytes) -> bytes:
    """Parts with their lengths in front, so that no two lists give one string."""
    return b"".join(len(part).to_bytes(4, "little") + part for part in parts)


def prologue(own: str, peer: str) -> bytes:
    """What both ends of a handshake take for granted: the version and both names."""
    first, second = sorted((own.encode(), peer.encode()))
    return join(b"cohaptic link", bytes([VERSION]), first, second)
