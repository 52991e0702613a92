"""Putting an FMU together: a zip whose bytes depend on nothing but its content."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Mapping
from pathlib import Path

from fmus import description2, description3
from fmus.compiler import PLATFORMS
from fmus.table import Model

FLAVOURS = ("fmi2", "fmi3", "fmi3-arrays")
"""FMI 2.0; FMI 3.0 with scalars, the default; FMI 3.0 with arrays."""


def fmu_bytes(
    model: Model,
    flavour: str,
    libraries: Mapping[str, bytes],
    *,
    token: str,
    further: Mapping[str, bytes],
) -> bytes:
    """The archive; ``libraries`` maps FMI 3.0 platform names to shared libraries.

    ``further`` are files by their path in it: licences, and the table of the state.
    """
    arrays = flavour == "fmi3-arrays"
    files: dict[str, bytes] = {}
    if flavour == "fmi2":
        files["modelDescription.xml"] = description2.model_description(model, token=token)
    else:
        files["modelDescription.xml"] = description3.model_description(
            model, token=token, arrays=arrays
        )
    terminals = description3.terminals(model, arrays=arrays)
    if terminals is not None:
        files[description3.TERMINALS_FILE] = terminals
    for platform in PLATFORMS:
        if platform.name not in libraries:
            continue
        folder = platform.fmi2 if flavour == "fmi2" else platform.name
        if folder is not None:
            name = f"binaries/{folder}/{model.name}{platform.suffix}"
            files[name] = libraries[platform.name]
    if flavour == "fmi2" and {"x86_64-darwin", "aarch64-darwin"} <= libraries.keys():
        files[f"binaries/darwin64/{model.name}.dylib"] = universal_binary(
            libraries["x86_64-darwin"], libraries["aarch64-darwin"]
        )
    return zip_bytes({**files, **further})


def zip_bytes(files: Mapping[str, bytes]) -> bytes:
    """A zip with fixed dates and modes, files in the order given."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, compresslevel=6)
    return buffer.getvalue()


def universal_binary(x86_64: bytes, aarch64: bytes) -> bytes:
    """A Mach-O file for both processors, because FMI 2.0 has one folder for macOS.

    Layout: big-endian header and table of (cpu type, subtype, offset, size, alignment), then the
    two images, each at a multiple of 2^14 bytes (<mach-o/fat.h>).
    """
    alignment = 14
    slices = ((0x01000007, 3, x86_64), (0x0100000C, 0, aarch64))
    head = struct.pack(">II", 0xCAFEBABE, len(slices))
    body = b""
    offset = 1 << alignment
    for cpu, subtype, image in slices:
        head += struct.pack(">5I", cpu, subtype, offset, len(image), alignment)
        body += image + bytes(-len(image) % (1 << alignment))
        offset = (1 << alignment) + len(body)
    return head + bytes((1 << alignment) - len(head)) + body


def licence_files(folder: Path) -> dict[str, bytes]:
    """The licences of what is inside every FMU; ``folder`` is ``fmus/``."""
    own = folder / "LICENSE"  # in a wheel
    return {
        "cohaptic-LICENSE.txt": (own if own.is_file() else folder.parent / "LICENSE").read_bytes(),
        "fmi-headers-LICENSE.txt": (folder / "fmi" / "headers" / "LICENSE").read_bytes(),
        "musl-COPYRIGHT.txt": (folder / "libm" / "COPYRIGHT").read_bytes(),
    }
