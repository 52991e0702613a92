"""What is read quickly is what the careful reader makes of it, places included, or it is not read.

Every YAML file of the repository, mutants of them, and texts that YAML 1.1 and 1.2 see differently.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import cosim
from cosim.base.document import yaml_reader
from cosim.base.document.node import Node
from cosim.base.document.yaml_quick import MAX_DEPTH, compose_quickly
from cosim.base.document.yaml_reader import parse_carefully, parse_yaml
from cosim.base.errors import InputError

ROOT = Path(cosim.__file__).parents[1]
FILES = sorted(
    file for folder in ("scenarios", "hil", "tests") for file in (ROOT / folder).rglob("*.yaml")
)
MUTANTS = 3_000
SMALL = """a: 1
b:
  - x
  - y: 2.5
    z: "q\\n w"
c: {d: 'e', f: [g, h, 1.0]}
d: |
  text
   more

e: >-
  folded
  text

    kept
f: &x {k: v}
g: *x
h: {<<: *x, m: n}
i: plain text
  goes on
j: "double
  goes on"
"""
WORDS = [
    *"\"'#&*:-,[]{}|>?@`<=~ \n.0123456789e+_xab%\\é",
    *(": ", "- ", "\n  ", "\n    ", "? ", "<<: ", "null", "true", "yes", "0x1F", "0o7", "1_000"),
    *("1e5", "+1", ".5", ".inf", "&a ", "*a ", "|\n", "|-\n", ">+\n", ">2\n", '"\\u00e9"', "''"),
    *(
        '""',
        "#c",
        "0b1",
        "12:30",
        "2001-01-01",
        "1.",
        "1.e5",
        "1e",
        "- - ",
        "{a: b}",
        "{a}",
        "!!x ",
    ),
]
DOUBTFUL = (
    *("0o17", "017", "0x1f", "0b11", "1_000", "1e", ".5", ".inf", "-.INF", ".nan", "12:30:45", "="),
    *(
        "+.5",
        "1__0",
        "0.",
        "08",
        "0_7",
        "1e5_",
        "",
        "!!str 1",
        "\t1",
        "1\r",
        "\ufeff1",
        "\x85",
        "%x",
    ),
)


def quickly(text: str) -> Node | None:
    """What the quick reader gives, where it gives anything."""
    root = compose_quickly(text)
    if root is None:
        return None
    try:
        return yaml_reader._Builder("file", text, True).build(root, None)
    except InputError:
        return None


def carefully(text: str) -> Node | str:
    try:
        return parse_carefully(text, "file")
    except InputError as error:
        return str(error)


def mutant(draw: random.Random, text: str) -> str:
    for _ in range(draw.choice((1, 1, 2, 4))):
        place = draw.randrange(len(text) + 1)
        lines = text.split("\n")
        line, other = draw.randrange(len(lines)), draw.randrange(len(lines))
        match draw.randrange(6):
            case 0:
                text = text[:place] + draw.choice(WORDS) + text[place:]
            case 1:
                text = text[:place] + draw.choice(WORDS) + text[place + 1 :]
            case 2:
                text = text[:place] + text[place + draw.choice((1, 2, 5, 20)) :]
            case 3:
                lines[line], lines[other] = lines[other], lines[line]
                text = "\n".join(lines)
            case 4:
                lines.insert(other, lines[line])
                text = "\n".join(lines)
            case _:
                lines[line] = draw.choice((" ", "  ")) + lines[line]
                text = "\n".join(lines)
    return text


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_our_files_are_read_quickly_and_alike(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    found = quickly(text)
    assert found is not None, "it needs the careful reader"
    assert repr(found) == repr(carefully(text))


def test_mutants_are_read_alike_or_carefully() -> None:
    draw = random.Random(4)
    lines = [file.read_text(encoding="utf-8").split("\n") for file in FILES]
    pieces = [
        SMALL,
        *("\n".join(f[n : n + 12]) + "\n" for f in lines for n in range(0, len(f), 12)),
    ]
    accepted = 0
    for number in range(MUTANTS):
        text = mutant(draw, SMALL if number % 4 == 0 else draw.choice(pieces))
        found = quickly(text)
        if found is not None:
            accepted += 1
            assert repr(found) == repr(carefully(text)), text
    assert accepted > MUTANTS / 10


@pytest.mark.parametrize("value", DOUBTFUL)
def test_what_the_versions_see_differently_is_read_carefully(value: str) -> None:
    for text in (f"a: {value}\n", f"- {value}\n", f"{{a: [{value}]}}\n"):
        found = quickly(text)
        assert found is None or repr(found) == repr(carefully(text))
        assert found is None or isinstance(carefully(text), Node)


@pytest.mark.parametrize("depth", [MAX_DEPTH + 1, 100_000])
def test_depth_is_no_danger(depth: int) -> None:
    assert quickly("[" * depth + "]" * depth) is None
    with pytest.raises(InputError):
        parse_yaml("{a: " * depth, "file")


def test_errors_are_the_careful_readers() -> None:
    for text in ("a: 1\na: 2\n", "a: [1\n", "a: *b\n", "{mode:step}\n", "a: 1,024\n b: 2\n"):
        with pytest.raises(InputError) as quick:
            parse_yaml(text, "file")
        assert str(quick.value) == carefully(text)
