"""Ten thousand spoiled files: accepted without a NaN in it, or refused at a line of the file."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError, InputErrors
from cosim.reading import FORMS
from cosim.scenario import load as load_scenario
from hil.setup.device_file import load as load_device_file
from tests.fuzz.mutation import mutated
from tests.fuzz.seeds import DEVICE_FILE, SCENARIO
from tests.support.scenario.small_scenario import SMALL

DEVICES = (
    DEVICE_FILE.decode(),
    "driver: haply\nhome: [2.4, 0.7]\nlimits: {torque: 0.1}\nsettings: {ports: [2, 1]}\n",
    "driver: odrive\nestop: confirmed\nsettings: {current_limit: 5}\n",
    "driver: odrive\nworkspace: {left: -0.1, right: 0.1, bottom: 0.05, top: 0.2}\n",
)
SCENARIOS = (
    SCENARIO.decode(),
    SMALL,
    SMALL + "safety: {torque: 0.1}\nrealtime: {on_miss: stop}\nlink: {delay: 2, fade: 50 ms}\n"
    "seed: 3\nbase_rate: 1024\n",
)


def numbers(value: Any) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            if field.name != "root":  # what was written, of which only what was read is used
                yield from numbers(getattr(value, field.name))
    elif isinstance(value, Mapping):
        for item in value.values():
            yield from numbers(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from numbers(item)


def judge(file: Path, read: Callable[[Path], Any]) -> bool:
    """Whether it was accepted; a refusal stands at a line of this file."""
    lines = file.read_bytes().count(b"\n") + 1
    try:
        accepted = read(file)
    except InputError as error:
        for each in error.errors if isinstance(error, InputErrors) else [error]:
            assert each.location is not None, each
            assert Path(each.location.file).name == file.name, each
            assert 1 <= each.location.line <= lines + 1, each
            assert each.message.strip()
        return False
    assert all(map(math.isfinite, numbers(accepted))), file.read_text()
    return True


def many(folder: Path, seeds: tuple[str, ...], read: Callable[[Path], Any], count: int) -> None:
    file = folder / "spoiled.yaml"
    accepted = 0
    for number in range(count):
        file.write_bytes(mutated(seeds[number % len(seeds)], random.Random(number)))
        try:
            accepted += judge(file, read)
        except Exception as error:
            error.add_note(f"mutation {number}:\n{file.read_bytes().decode(errors='replace')}")
            raise
    assert 0 < accepted < count


COUNTS = [
    600,
    pytest.param(3_000, marks=pytest.mark.slow),
    pytest.param(10_000, marks=pytest.mark.exhaustive),
]


def scenario(file: Path) -> Any:
    return load_scenario(file, forms=FORMS)


@pytest.mark.parametrize("count", COUNTS)
def test_scenarios(tmp_path: Path, count: int) -> None:
    many(tmp_path, SCENARIOS, scenario, count)


@pytest.mark.parametrize("count", COUNTS)
def test_device_files(tmp_path: Path, count: int) -> None:
    many(tmp_path, DEVICES, load_device_file, count)
