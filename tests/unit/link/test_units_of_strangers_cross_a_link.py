"""Units that only an FMU knows go between two stations as they go over a simulated channel."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.link.session.contract import Contract
from cosim.master.assembly.assemble import Assembly, put_together
from cosim.preparation.prepare import prepare
from cosim.scenario import load
from cosim.station.contract import contract_of
from cosim.station.halves import _stand_ins, refuse_unusable_halves
from cosim.station.split import split
from tests.support.fmus.foreign import foreign_fmu, scalar

UNITS = (
    '<UnitDefinitions><Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="100000"/></Unit>'
    '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    '<Unit name="K"><BaseUnit K="1"/></Unit><Unit name="blips"/>'
    '<Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>'
)
STRUCTURE = '<Output valueReference="1" dependencies=""/>'


def joined(folder: Path, units: tuple[str, str], more: str = "") -> Assembly:
    """``a`` at one station has an output, ``b`` at the other an input."""
    for name, unit in zip("ab", units, strict=True):
        variables = scalar(3, "y", 1, causality="output", unit=unit)
        variables += scalar(3, "u", 2, causality="input", start="0", unit=unit)
        foreign_fmu(folder, 3, variables, before=UNITS, name=name, structure=STRUCTURE)
    file = folder / "scenario.yaml"
    file.write_text(
        "cohaptic: 1\nduration: 1\ncomponents:\n"
        "  a: {fmu: ./a.fmu, station: one, rate: 64}\n"
        "  b: {fmu: ./b.fmu, station: two, rate: 64}\n"
        "channels:\n  lan: {between: [one, two], rate: 64}\n"
        f"connections: [{{from: a.y, to: b.u, via: lan{more}}}]\n",
        encoding="utf-8",
    )
    return put_together(load(file))


def transform(assembly: Assembly) -> tuple[float, float]:
    """What becomes of the value that ``b.u`` is given: factor and offset."""
    (wire,) = [w for w in assembly.wiring.wires if w.target.component == "b"]
    return wire.gain, wire.offset


def received(whole: Assembly) -> tuple[float, float]:
    """The same at station two, where the value comes out of a link."""
    half = split(whole, "two")
    prepared = prepare(half.scenario, instances=_stand_ins(half), recorded=False)
    with prepared.simulation as simulation:
        return transform(simulation.assembly)


def contracts(whole: Assembly) -> set[bytes]:
    halves = [split(whole, own) for own in ("one", "two")]
    return {Contract(contract_of(whole, half, half.peers[0])).hash for half in halves}


@pytest.mark.parametrize(
    ("units", "more"),
    [
        (("bar", "bar"), ""),
        (("bar", "Pa"), ""),
        (("degC", "K"), ""),
        (("blips", "blips"), ""),
        (("blips", "m"), ""),
        (("blips", "m"), ", unit: ignore"),
        (("bar", "m"), ", unit: ignore"),
        (("bar", "m"), ", unit: ignore, factor: 3, offset: -1"),
        (("degC", "K"), ", factor: 2, offset: 5"),
    ],
)
def test_a_link_makes_of_a_value_what_the_channel_makes(
    tmp_path: Path, units: tuple[str, str], more: str
) -> None:
    whole = joined(tmp_path, units, more)
    refuse_unusable_halves(whole)
    assert received(whole) == transform(whole)
    assert len(contracts(whole)) == 1


def test_the_contract_has_what_is_made_of_values(tmp_path: Path) -> None:
    several = [
        contracts(joined(tmp_path, *each))
        for each in (
            (("bar", "bar"),),
            (("blips", "bar"),),
            (("bar", "m"), ", unit: ignore"),
            (("bar", "bar"), ", factor: 2"),
        )
    ]
    assert len(set.union(*several)) == len(several)


def test_units_that_do_not_agree_are_refused_before_a_link_is_opened(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="bar"):
        joined(tmp_path, ("bar", "m"))
