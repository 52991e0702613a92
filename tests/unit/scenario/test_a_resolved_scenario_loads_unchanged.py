"""The resolved copy of any valid scenario loads as the same scenario, and resolves to itself."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from cosim.scenario import Scenario, load
from cosim.scenario.impairments.trace import Trace
from cosim.scenario.resolved import to_yaml
from cosim.scenario.source.find import bundled_names
from tests.support.scenario.scenario_documents import documents

BUNDLED = [name for name in bundled_names() if "/" not in name]


@settings(
    deadline=None,
    max_examples=40,
    phases=[Phase.reuse, Phase.generate],  # shrinking a whole document takes minutes
    suppress_health_check=[HealthCheck.too_slow],
)
@given(documents())
def test_resolving_is_idempotent(tmp_path_factory: pytest.TempPathFactory, document: Any) -> None:
    folder = tmp_path_factory.mktemp("resolved", numbered=True)
    first = load(_write(folder / "first.yaml", json.dumps(document)))
    again = load(_write(folder / "second.yaml", to_yaml(first)))
    assert again == first
    assert to_yaml(again) == to_yaml(first)
    _check_written(document, first)


def _check_written(document: dict[str, Any], scenario: Scenario) -> None:
    """What was written is what was understood, where both can be compared directly."""
    assert scenario.seed == document["seed"]
    assert scenario.title == document["title"]
    assert list(scenario.components) == list(document["components"])
    for name, written in document["components"].items():
        component = scenario.components[name]
        assert component.station == written["station"]
        assert component.period * component.rate == scenario.base_rate
        for variable, value in written.get("parameters", {}).items():
            found = component.parameters[variable]
            expected = tuple(value) if isinstance(value, list) else value
            assert found == expected
            assert type(found) is type(expected)
    for way in (scenario.channels["lan"].forward, scenario.channels["lan"].backward):
        jitter = way.impairments.get("jitter")
        assert jitter is None or math.isclose(sum(jitter.weights), 1.0, abs_tol=1e-9)
        assert way.delay.ticks >= 0
    assert len(scenario.connections) == len(document["connections"])


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_scenarios_resolve_to_themselves(name: str, tmp_path: Path) -> None:
    first = load(name)
    again = load(_write(tmp_path / "resolved.yaml", to_yaml(first)))
    assert again == first
    assert again.name == name


def test_a_resolved_scenario_does_not_depend_on_where_it_lies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "trace.txt").write_text("# measured\n0.002\nlost\n0\n", "utf-8")
    (tmp_path / "run").mkdir()
    file = _write(
        tmp_path / "s.yaml",
        "cohaptic: 1\nduration: 1\nrates: {r: 1000}\n"
        "components: {a: {playback: run, station: a}, b: {fmu: pantograph, station: b}}\n"
        "channels: {lan: {between: [a, b], trace: trace.txt}}",
    )
    first = load(file)
    assert first.channels["lan"].forward.impairments == {"trace": Trace((2, -1, 0))}
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert load(_write(elsewhere / "r.yaml", to_yaml(first))) == first


def _write(file: Path, text: str) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


def test_a_device_file_is_beside_the_file_that_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench, elsewhere = tmp_path / "bench", tmp_path / "elsewhere"
    bench.mkdir()
    elsewhere.mkdir()
    device = "{device: {url: 'mock://', file: left.json}, rate: 1024}"
    (bench / "overlay.yaml").write_text(f"components: {{left: {device}}}")
    (tmp_path / "s.yaml").write_text(
        "cohaptic: 1\nduration: 1\ncomponents:\n  left: {fmu: pantograph, rate: 1024}\n"
    )
    monkeypatch.chdir(elsewhere)
    scenario = load("../s.yaml", ["../bench/overlay.yaml"])
    assert scenario.components["left"].options["file"] == str(bench / "left.json")
    (elsewhere / "again.yaml").write_text(to_yaml(scenario), encoding="utf-8")
    assert load("again.yaml").components["left"].options["file"] == str(bench / "left.json")
    given = load("../s.yaml", ["../bench/overlay.yaml"], ["components.left.device.file=b.json"])
    assert given.components["left"].options["file"] == str(elsewhere / "b.json")
