"""A snapshot: everything that the rest of a run depends on, as plain bytes and arrays.

The file: a line with the format's number, the SHA-256 of what follows, and a NumPy archive: a JSON
``header`` and arrays of whole numbers and bytes. It holds no pointer and no code.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError

FORMAT = 1
_MAGIC = b"cohaptic snapshot "
_HEAD = _MAGIC + b"%d\n" % FORMAT
_DIGEST_BYTES = 32


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """The state of a run at a tick, before anything of that tick was done.

    ``Simulation.snapshot`` takes one, and ``Simulation.restore`` goes on from it.
    """

    tick: int
    plan: str
    """What the numbers depend on besides the components: a digest (``fingerprint``)."""
    components: Mapping[str, Mapping[str, str | None]]
    """What each component is, by name."""
    values: Mapping[str, Any]
    """Counters, and what Python components and draws remember; plain values."""
    arrays: Mapping[str, NDArray[Any]]
    """Cells, packets, fates, and FMU states as bytes."""

    @property
    def size(self) -> int:
        """Bytes of all arrays, not compressed."""
        return sum(array.nbytes for array in self.arrays.values())

    def to_bytes(self) -> bytes:
        """The file's content."""
        header = {
            "tick": self.tick,
            "plan": self.plan,
            "components": self.components,
            "values": self.values,
        }
        text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
        buffer = io.BytesIO()
        arrays: dict[str, Any] = dict(self.arrays)
        np.savez_compressed(buffer, header=text, **arrays)
        body = buffer.getvalue()
        return _HEAD + hashlib.sha256(body).digest() + body

    @staticmethod
    def from_bytes(content: bytes, name: str = "the snapshot") -> Snapshot:
        """What ``to_bytes`` returned; ``name`` is how sentences call it.

        Raises:
            InputError: it is no snapshot, one of another version, or damaged.
        """
        head, _, rest = content.partition(b"\n")
        if not head.startswith(_MAGIC):
            raise InputError(f"{name} is not a snapshot of a run.")
        if head + b"\n" != _HEAD:
            found = head[len(_MAGIC) :][:20].decode("ascii", "replace")
            raise InputError(
                f"{name} has format {found}; this version reads format {FORMAT}. Take it again "
                "with 'cohaptic run --snapshot'."
            )
        body = rest[_DIGEST_BYTES:]
        if rest[:_DIGEST_BYTES] != hashlib.sha256(body).digest():
            raise InputError(f"{name} is damaged or cut off; take it again.")
        # Behind the digest is what to_bytes wrote.
        with np.load(io.BytesIO(body), allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
        header = cast("dict[str, Any]", json.loads(arrays.pop("header").tobytes()))
        return Snapshot(arrays=arrays, **header)

    def write(self, file: Path) -> None:
        """Write the file whole, or not at all.

        Raises:
            OSError: it cannot be written.
        """
        scratch = file.with_name(f"{file.name}.{os.getpid()}")
        try:
            scratch.write_bytes(self.to_bytes())
            scratch.replace(file)
        finally:
            scratch.unlink(missing_ok=True)


def read_snapshot(file: Path) -> Snapshot:
    """A snapshot from its file.

    Raises:
        InputError: the file cannot be read, or is not a whole snapshot of this version.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror}.") from None
    return Snapshot.from_bytes(content, str(file))
