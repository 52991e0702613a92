"""Every structure and constant of ``kernel.h`` is what Python takes it for, byte by byte.

The header is read for its structures, so that none can be forgotten; the compiler says where each
field lies.
"""

from __future__ import annotations

import ctypes
import re
from enum import IntEnum

import pytest

from cosim.master.kernel import build, codes, event_structures, fmu_structures, native, structures
from fmus.compiler import compile_library, host_platform

MIRRORS: dict[str, type[ctypes.Structure]] = {
    name.removesuffix("Struct"): value
    for module in (structures, event_structures, fmu_structures)
    for name, value in vars(module).items()
    if name.endswith("Struct")
}
HEADERS = [build.SOURCES / name for name in ("kernel.h", "events.h")]
TEXT = re.sub(
    r"/\*.*?\*/",
    "",
    "\n".join(each.read_text(encoding="utf-8") for each in HEADERS),
    flags=re.DOTALL,
)
STRUCTS = {
    name: [
        re.sub(r"[*\s]", " ", field).split()[-1]
        for line in body.split(";")
        if line.strip()
        for field in line.split(",")
    ]
    for body, name in re.findall(r"typedef struct \w*\s*\{([^}]*)\} (\w+);", TEXT)
}
ENUMS = {
    name: re.findall(r"(\w+) =", body)
    for body, name in re.findall(r"typedef enum \{([^}]*)\} (\w+);", TEXT)
}


def layout(struct: str, fields: list[str]) -> list[tuple[str, int, int]]:
    """Offset and size of each field, as the compiler has them; last, the size of the whole."""
    values = [
        f"__builtin_offsetof({struct}, {name}), sizeof((({struct} *)0)->{name})" for name in fields
    ]
    numbers = _compiled([*values, f"sizeof({struct})"], 2 * len(fields) + 1)
    places = [(n, numbers[2 * i], numbers[2 * i + 1]) for i, n in enumerate(fields)]
    return [*places, (struct, 0, numbers[-1])]


def in_python(struct: type[ctypes.Structure], name: str) -> list[tuple[str, int, int]]:
    """The same of a ctypes structure."""
    places = [
        (field, getattr(struct, field).offset, getattr(struct, field).size)
        for field, *_ in struct._fields_
    ]
    return [*places, (name, 0, ctypes.sizeof(struct))]


def _compiled(values: list[str], count: int) -> list[int]:
    source = FOLDER / "abi.c"
    joined = ", ".join(values)
    source.write_text(
        '#include "events.h"\n'
        f'__attribute__((visibility("default"))) const int64_t abi[] = {{{joined}}};\n'
    )
    library = FOLDER / f"abi_{abs(hash(joined))}.so"
    compile_library(host_platform(), library, [source], include=[build.SOURCES])
    return list((ctypes.c_int64 * count).in_dll(ctypes.CDLL(str(library)), "abi"))


@pytest.fixture(scope="module", autouse=True)
def _folder(tmp_path_factory: pytest.TempPathFactory) -> None:
    global FOLDER
    FOLDER = tmp_path_factory.mktemp("abi")


def test_the_header_was_read_whole() -> None:
    assert len(STRUCTS) == TEXT.count("typedef struct") > 0
    assert len(ENUMS) == TEXT.count("typedef enum") > 0
    assert set(MIRRORS) == set(STRUCTS)


@pytest.mark.parametrize("name", STRUCTS)
def test_a_structure_lies_where_the_compiler_puts_it(name: str) -> None:
    assert in_python(MIRRORS[name], name) == layout(name, STRUCTS[name])


def test_a_wrong_structure_is_noticed() -> None:
    class Wrong(ctypes.Structure):
        _fields_ = [
            ("rows", ctypes.c_void_p),
            ("row", ctypes.c_int32),
            ("row_count", ctypes.c_int32),
        ]

    assert in_python(Wrong, "Record") != layout("Record", STRUCTS["Record"])


@pytest.mark.parametrize(
    ("name", "mirror"),
    [
        ("Outcome", codes.KernelOutcome),
        ("Kind", codes.OperationKind),
        ("EventCall", codes.EventCall),
        ("EventFault", codes.EventFault),
        ("ClockKind", codes.ClockKind),
    ],
)
def test_constants_have_the_headers_values(name: str, mirror: type[IntEnum]) -> None:
    names = ENUMS[name]
    values = _compiled(list(names), len(names))
    prefix = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).upper() + "_"
    assert dict(zip((n.removeprefix(prefix) for n in names), values, strict=True)) == {
        member.name: member.value for member in mirror
    }
    assert _compiled(
        ["KERNEL_ABI", "sizeof(Cell)", "CLOCK_CELLS", "CLOCK_COUNT", "CLOCK_AGE"], 5
    ) == [
        native.ABI,
        8,
        codes.CLOCK_CELLS,
        codes.CLOCK_COUNT,
        codes.CLOCK_AGE,
    ]


def test_types_have_the_headers_codes() -> None:
    names = ENUMS["Type"]
    numbers = dict(zip(names, _compiled(list(names), len(names)), strict=True))
    for kind, code in codes.TYPE_CODES.items():
        name = {"ENUMERATION": "INT64"}.get(kind.name, kind.name)
        assert numbers[f"TYPE_{name}"] == code
