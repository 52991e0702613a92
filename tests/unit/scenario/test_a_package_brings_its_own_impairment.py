"""An impairment is one file and one entry point: nothing of cohaptic knows its name."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cosim.base.counter import stream_key
from cosim.base.errors import InputError
from cosim.master.channels.fates import Fates
from cosim.scenario import Scenario, load
from cosim.scenario.describe import average, describe
from cosim.scenario.form.channel import channel_form
from cosim.scenario.form.document import document_form, json_schema
from cosim.scenario.impairments.registry import impairments
from cosim.scenario.resolved import to_yaml

SOURCE = '''
"""Stalls: now and then a packet waits, as while a radio changes its cell."""
from dataclasses import dataclass
from typing import ClassVar

from cosim.base.counter import happens
from cosim.scenario.form.fields import Delay, Probability
from cosim.base.document.form import Form
from cosim.scenario.impairments import Average, Effect, Impairment, ImpairmentProblem


class StallForm(Form):
    """Packets that wait."""

    probability: Probability
    wait: Delay


@dataclass(frozen=True, slots=True)
class Stall(Effect):
    order: ClassVar[int] = 15
    probability: float
    ticks: int

    def write(self, period):
        return {"probability": self.probability, "wait": f"{self.ticks} ticks"}

    def describe(self):
        return {"probability": self.probability, "ticks": self.ticks}

    def sentence(self):
        return f"stall {self.probability:g} by {self.ticks} ticks"

    def range(self, shortest, longest):
        return shortest, longest + self.ticks

    def draw(self, key):
        def wait(packets):
            hit = happens(key, 0, self.probability, packets.first, packets.count)
            packets.delays[hit & packets.arrives] += self.ticks
        return wait

    def average(self, before):
        p = self.probability
        return Average(
            before.delay + p * self.ticks,
            before.variance + p * (1 - p) * self.ticks**2,
            before.lost,
        )


def resolve(written, setting):
    ticks = setting.ticks(written.wait)
    if ticks == 0:
        raise ImpairmentProblem("a wait of 0 does nothing; leave it out.")
    return Stall(written.probability, ticks) if written.probability else None


STALL = Impairment(
    name="stall", description="Packets that wait.", form=StallForm, resolve=resolve
)
'''

LAN = "channels: {lan: {between: [a, b], rate: network, each_way_delay: 1, LAN}}"
TEXT = f"""cohaptic: 1
duration: 2
seed: 3
rates: {{control: 1024, network: 128}}
components:
  hand: {{fmu: signal, station: a, rate: control, parameters: {{mode: sine, frequency: 6}}}}
  object: {{fmu: object, station: b, rate: control}}
{LAN}
connections: ["hand.value -> object.force[1] via lan"]
"""
STALLED = "stall: {probability: 20 %, wait: 3}"


@pytest.fixture(name="package")
def _package(tmp_path: Path) -> Path:
    """An installed distribution, as pip leaves it."""
    folder = tmp_path / "site"
    info = folder / "stalls-1.0.dist-info"
    info.mkdir(parents=True)
    (folder / "stalls.py").write_text(SOURCE, "utf-8")
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stalls\nVersion: 1.0\n", "utf-8")
    (info / "entry_points.txt").write_text(
        "[cohaptic.impairments]\nstall = stalls:STALL\n", "utf-8"
    )
    return folder


def _forget() -> None:
    for cached in (impairments, channel_form, document_form):
        cached.cache_clear()
    sys.modules.pop("stalls", None)


@pytest.fixture(name="installed")
def _installed(package: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.syspath_prepend(str(package))
    _forget()
    yield package
    monkeypatch.undo()
    _forget()


def _written(folder: Path, lan: str) -> Path:
    file = folder / "s.yaml"
    file.write_text(TEXT.replace("LAN", lan), "utf-8")
    return file


def _loaded(folder: Path, lan: str = STALLED) -> Scenario:
    return load(_written(folder, lan))


def test_without_the_package_its_key_is_unknown(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"s\.yaml:8:\d+: unknown key 'stall' in channels\.lan"):
        _loaded(tmp_path)


@pytest.mark.usefixtures("installed")
def test_it_is_in_the_schema_and_described(tmp_path: Path) -> None:
    properties = json_schema()["$defs"]["ChannelForm"]["properties"]
    assert properties["stall"]["description"] == "Packets that wait."
    scenario = _loaded(tmp_path)
    forward = describe(scenario)["channels"]["lan"]["forward"]
    assert forward["stall"] == {"probability": 0.2, "ticks": 24}
    assert forward["sentence"] == "delay 8 ticks (1 sample), stall 0.2 by 24 ticks"
    assert average(scenario.channels["lan"].forward).delay == pytest.approx(8 + 0.2 * 24)


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("lan", "sentence"),
    [
        ("stal: 1", "unknown key 'stal' in channels.lan. Did you mean stall?"),
        (
            "stall: {probability: 0.1, wiat: 3}",
            "unknown key 'wiat' in channels.lan.stall. Did you mean wait?",
        ),
        (
            "stall: {backward: {probability: 2, wait: 1}}",
            "channels.lan.stall.backward.probability: 2 is not a probability: it is from 0 to 1",
        ),
        (
            "stall: {probability: 1, wait: 0}",
            "channels.lan.stall: a wait of 0 does nothing; leave it out.",
        ),
    ],
)
def test_what_is_wrong_in_it_is_a_located_sentence(tmp_path: Path, lan: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        _loaded(tmp_path, lan)
    assert sentence in str(caught.value)
    assert "s.yaml:8:" in str(caught.value)


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("lan", [STALLED, "stall: {backward: {probability: 1, wait: 3 ms}}"])
def test_it_is_written_back(tmp_path: Path, lan: str) -> None:
    scenario = _loaded(tmp_path, lan)
    (tmp_path / "r.yaml").write_text(to_yaml(scenario), "utf-8")
    assert load(tmp_path / "r.yaml") == scenario


@pytest.mark.usefixtures("installed")
def test_its_draws_are_its_own(tmp_path: Path) -> None:
    """Another impairment beside it changes neither: each draws from its own stream."""
    key = stream_key(3, "lan", "forward", "128")

    def extra(lan: str) -> np.ndarray:
        return Fates(_loaded(tmp_path, lan).channels["lan"].forward, key).begin().take(4000)[0] - 8

    alone, jitter = extra(STALLED), extra("jitter: 1")
    np.testing.assert_array_equal(extra(f"{STALLED}, jitter: 1"), alone + jitter)
    assert np.mean(alone == 24) == pytest.approx(0.2, abs=0.02)
    both = np.mean((alone > 0) & (jitter > 0))
    assert both == pytest.approx(0.1, abs=0.02)  # independent


def test_a_run_draws_it_and_runs_are_the_same(package: Path, tmp_path: Path) -> None:
    env = {**os.environ, "PYTHONPATH": str(package)}

    def digest(lan: str, out: str) -> str:
        file = _written(tmp_path, lan)
        folder = tmp_path / out
        words = ["run", str(file), "--out", str(folder), "--no-figure", "--json"]
        subprocess.run(_cli(words), env=env, check=True, capture_output=True)
        words = ["record", "digest", str(folder)]
        return subprocess.run(_cli(words), env=env, check=True, capture_output=True).stdout.decode()

    assert digest(STALLED, "one").split()[0] == digest(STALLED, "two").split()[0]
    assert digest(STALLED, "three").split()[0] != digest("loss: 0", "four").split()[0]
    checked = subprocess.run(
        _cli(["check", str(_written(tmp_path, STALLED)), "--json"]),
        env=env,
        check=True,
        capture_output=True,
    )
    channel = json.loads(checked.stdout)["channels"]["lan"]
    assert channel["backward"]["stall"]["ticks"] == 24


def _cli(words: list[str]) -> list[str]:
    return [sys.executable, "-c", "from cosim.cli import main; main()", *words]


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("stall = stalls:NOTHING", "the impairment 'stall' of stalls cannot be loaded"),
        ("stal = stalls:STALL", "leads to stalls:STALL, which is no impairment of that name"),
        ("rate = stalls:RATE", "a package brings an impairment 'rate', but channels have a key"),
        ("jitter = stalls:JITTER", "stalls brings an impairment 'jitter', but channels have"),
    ],
)
def test_a_package_that_brings_no_impairment_is_named(
    installed: Path, tmp_path: Path, line: str, sentence: str
) -> None:
    (installed / "stalls-1.0.dist-info" / "entry_points.txt").write_text(
        f"[cohaptic.impairments]\n{line}\n", "utf-8"
    )
    more = "".join(
        f"{name.upper()} = Impairment(name='{name}', description='', form=int, resolve=resolve)\n"
        for name in ("rate", "jitter")
    )
    (installed / "stalls.py").write_text(SOURCE + more, "utf-8")
    _forget()
    with pytest.raises(InputError) as caught:
        _loaded(tmp_path, "loss: 0")
    assert sentence in str(caught.value)


def test_an_impairment_that_is_built_in_is_one_file_and_one_word() -> None:
    """No other file of cohaptic speaks of it by name; how it is written stands in the docs."""
    root = Path(__file__).parents[3]
    for name in ("reorder", "duplication"):
        speaking = {
            str(file.relative_to(root))
            for folder in ("base", "scenario", "master")
            for file in (root / "cosim" / folder).rglob("*.py")
            if name in _code(file)
        }
        own = f"cosim/scenario/impairments/{name}.py"
        assert speaking <= {own, "cosim/scenario/impairments/registry.py"}


def _code(file: Path) -> str:
    """Every name and text of a file that is no docstring."""
    import ast

    tree = ast.parse(file.read_text("utf-8"))
    docs = {
        id(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    words = [
        getattr(node, "id", None) or getattr(node, "attr", None) or getattr(node, "module", None)
        for node in ast.walk(tree)
    ]
    words += [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs
    ]
    return "\n".join(word.lower() for word in words if isinstance(word, str))
