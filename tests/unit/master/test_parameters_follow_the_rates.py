"""A model's sample period and network period are the scenario's, and nothing else is accepted."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.assembly.assemble import put_together
from cosim.master.run.simulation import assemble
from cosim.scenario import load
from cosim.station.split import split


@pytest.mark.parametrize(
    ("sets", "period", "network"),
    [
        ((), 1 / 1024, 8),
        (("rates.network=64",), 1 / 1024, 16),
        (("rates.control=1000", "rates.network=100"), 1e-3, 10),
        (("rates.control=1000", "rates.network=1000"), 1e-3, 1),
        (("components.vr_a.substeps=2", "components.vr_b.substeps=2"), 1 / 2048, 16),
    ],
)
def test_they_are_those_of_the_scenario(sets: tuple[str, ...], period: float, network: int) -> None:
    assembly = put_together(load("two_users_box", (), sets))
    told = {
        part: participant.parameters
        for part, participant in assembly.participants.items()
        if "network_ticks" in participant.interface.variables
    }
    assert len(told) == 2
    for parameters in told.values():
        assert parameters["sample_period"] == [period]
        assert parameters["network_ticks"] == [network]


@pytest.mark.parametrize(
    ("rates", "due"),
    [(("rates.network=64",), 64), (("rates.control=1000", "rates.network=100"), 100)],
)
def test_as_many_packets_are_due_as_the_network_takes(rates: tuple[str, ...], due: int) -> None:
    scenario = load("two_users_box", (), (*rates, "duration=1", "record=[vr_a.packets_due]"))
    sink = MemorySink()
    with assemble(scenario) as simulation:
        simulation.run(sink)
    assert sink.signal("vr_a.packets_due")[-1] == due


def test_a_half_of_a_scenario_knows_the_network_too() -> None:
    """The channel itself is not in it: a link stands in its place."""
    full = put_together(load("two_users_box", (), ("rates.network=64",)))
    half = split(full, "station_a").scenario
    assert half.channels == {}
    assert half.components["vr_a"].parameters["network_ticks"] == 16


@pytest.mark.parametrize(
    ("parameter", "sentence"),
    [
        (
            "sample_period: 1 ms",
            "vr.sample_period is 0.001, but vr runs at 1024 Hz, so it is 0.0009765625",
        ),
        (
            "network_ticks: 4",
            "vr.network_ticks is 4, but vr sends at 128 Hz and runs at 1024 Hz, so it is 8",
        ),
    ],
)
def test_what_contradicts_the_rates_is_refused_at_its_place(
    tmp_path: Path, parameter: str, sentence: str
) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(
        "cohaptic: 1\nduration: 1\nrates: {control: 1024, network: 128}\ncomponents:\n"
        "  vr:\n    fmu: distributed_workstation\n    station: a\n    rate: control\n"
        f"    parameters:\n      {parameter}\n"
        "  other: {fmu: distributed_workstation, station: b, rate: control}\n"
        "channels: {lan: {between: [a, b], rate: network}}\n"
        "connections: ['vr.shared -> other.peer_1 via lan']\n",
        "utf-8",
    )
    with pytest.raises(InputError) as caught:
        put_together(load(file))
    column = len(f"      {parameter.partition(':')[0]}: ") + 1
    advice = "Leave it out: it follows from the rates"
    assert str(caught.value) == f"{file}:10:{column}: {sentence}. {advice}"


def test_what_agrees_with_the_rates_may_be_said() -> None:
    sets = ("components.vr_a.parameters.network_ticks=8",)
    told = put_together(load("two_users_box", (), sets)).participants["vr_a"].parameters
    assert told["network_ticks"] == [8]


@pytest.mark.parametrize(("network", "noted"), [(128, False), (100, True)])
def test_a_network_period_that_is_no_whole_number_of_ticks_is_noted(
    network: int, noted: bool
) -> None:
    sets = (f"rates.network={network}", "base_rate=25600")
    notes = put_together(load("two_users_box", (), sets)).notes
    said = "vr_a sends at 100 Hz and runs at 1024 Hz: 10.24 of its periods to a packet"
    assert any(said in note for note in notes) is noted
