"""What a shared library exports and what it needs: ELF, PE and Mach-O, read with ``struct``.

No validator of FMUs looks at symbols, and a linker is content with a library that lacks some; so
every library is checked after it was compiled.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ALLOWED = {
    "linux": frozenset[str](),
    "windows": frozenset(
        {
            "CloseHandle",
            "CreateFileW",
            "GetProcessHeap",
            "HeapAlloc",
            "HeapFree",
            "MultiByteToWideChar",
            "ReadFile",
        }
    ),
    "darwin": frozenset(
        {
            "__bzero",
            "bzero",
            "calloc",
            "close",
            "dyld_stub_binder",
            "free",
            "memcmp",
            "memcpy",
            "memmove",
            "memset",
            "open",
            "read",
        }
    ),
}
"""What a library may take from the system, by the last part of the platform's name."""


@dataclass(frozen=True, slots=True)
class Symbols:
    """Names without a leading underscore; ``libraries`` are those loaded along with it."""

    exported: frozenset[str]
    needed: frozenset[str]
    libraries: frozenset[str]


def fmi_functions(headers: Path) -> frozenset[str]:
    """Every function that the FMI 2.0 and 3.0 headers declare for export."""
    names: set[str] = set()
    for name in ("fmi2Functions.h", "fmi3Functions.h"):
        text = (headers / name).read_text()
        names.update(re.findall(r"^\s*FMI[23]_Export\s+\w+\s+(\w+);", text, re.MULTILINE))
    return frozenset(names)


def symbols_of(image: bytes) -> Symbols:
    """The symbols of a 64-bit little-endian shared library.

    Raises:
        ValueError: it is none of the three formats.
    """
    if image[:4] == b"\x7fELF":
        return _elf(image)
    if image[:2] == b"MZ":
        return _pe(image)
    if image[:4] == b"\xcf\xfa\xed\xfe":
        return _mach_o(image)
    raise ValueError("not an ELF, PE or Mach-O library of 64 bits")


def _text(image: bytes, offset: int) -> str:
    return image[offset : image.index(b"\0", offset)].decode()


def _elf(image: bytes) -> Symbols:
    section_offset, size, count = (
        struct.unpack_from("<Q", image, 0x28)[0],
        *struct.unpack_from("<HH", image, 0x3A),
    )
    sections = [
        struct.unpack_from("<IIQQQQIIQQ", image, section_offset + size * i) for i in range(count)
    ]
    exported: set[str] = set()
    needed: set[str] = set()
    libraries: set[str] = set()
    for _, kind, _, _, offset, length, link, _, _, _ in sections:
        strings = sections[link][4] if kind in {6, 11} else 0
        if kind == 11:  # SHT_DYNSYM
            for place in range(offset + 24, offset + length, 24):
                name, info, other, section = struct.unpack_from("<IBBH", image, place)
                if section == 0:
                    needed.add(_text(image, strings + name))
                elif info >> 4 in {1, 2} and other & 3 == 0:
                    exported.add(_text(image, strings + name))
        elif kind == 6:  # SHT_DYNAMIC
            for place in range(offset, offset + length, 16):
                tag, value = struct.unpack_from("<QQ", image, place)
                if tag == 1:  # DT_NEEDED
                    libraries.add(_text(image, strings + value))
    return Symbols(frozenset(exported), frozenset(needed), frozenset(libraries))


def _pe(image: bytes) -> Symbols:
    head = struct.unpack_from("<I", image, 0x3C)[0]
    sections, optional = struct.unpack_from("<H12xH", image, head + 6)
    tables = head + 24 + 112
    mapped = [
        struct.unpack_from("<IIII", image, head + 24 + optional + 40 * i + 8)
        for i in range(sections)
    ]

    def at(address: int) -> int:
        for _, start, length, offset in mapped:
            if start <= address < start + length:
                return offset + address - start
        raise ValueError("an address outside every section")

    exported: set[str] = set()
    needed: set[str] = set()
    libraries: set[str] = set()
    export_address, import_address = struct.unpack_from("<I4xI", image, tables)
    if export_address:
        count, _, names = struct.unpack_from("<III", image, at(export_address) + 24)
        for i in range(count):
            name = struct.unpack_from("<I", image, at(names) + 4 * i)[0]
            exported.add(_text(image, at(name)))
    place = at(import_address) if import_address else 0
    while place and (entry := struct.unpack_from("<IIIII", image, place))[3]:
        libraries.add(_text(image, at(entry[3])).lower())
        needed.update(_text(image, at(thunk) + 2) for thunk in _thunks(image, at(entry[0])))
        place += 20
    return Symbols(frozenset(exported), frozenset(needed), frozenset(libraries))


def _thunks(image: bytes, place: int) -> Iterator[int]:
    while (value := struct.unpack_from("<Q", image, place)[0]) != 0:
        yield value & 0x7FFFFFFF
        place += 8


def _mach_o(image: bytes) -> Symbols:
    exported: set[str] = set()
    needed: set[str] = set()
    libraries: set[str] = set()
    place = 32
    for _ in range(struct.unpack_from("<I", image, 16)[0]):
        command, size = struct.unpack_from("<II", image, place)
        if command == 2:  # LC_SYMTAB
            offset, count, strings = struct.unpack_from("<III", image, place + 8)
            for i in range(count):
                name, kind = struct.unpack_from("<IB", image, offset + 16 * i)
                text = _text(image, strings + name).removeprefix("_")
                # Debugging entries, what is not external, and what a linker adds by itself.
                if kind & 0xE0 or not kind & 1 or text in {"__dso_handle", "_mh_dylib_header"}:
                    continue
                (exported if kind & 0x0E else needed).add(text)
        elif command == 0xC:  # LC_LOAD_DYLIB
            libraries.add(_text(image, place + struct.unpack_from("<I", image, place + 8)[0]))
        place += size
    return Symbols(frozenset(exported), frozenset(needed), frozenset(libraries))


def problems_of(image: bytes, platform: str, required: frozenset[str]) -> list[str]:
    """What is wrong with the library of a platform (``x86_64-linux``); empty when nothing is."""
    system = platform.split("-")[1]
    found = symbols_of(image)
    problems: list[str] = []
    if missing := sorted(required - found.exported):
        problems.append(f"it does not export {', '.join(missing)}")
    if extra := sorted(found.exported - required):
        problems.append(f"it exports {', '.join(extra)} as well")
    if undefined := sorted(found.needed - ALLOWED[system]):
        problems.append(f"it needs {', '.join(undefined)}, which is not there")
    return problems
