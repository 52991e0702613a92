"""A unit that a parameter takes, a connection takes, and the other way round; one table says so."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import product
from pathlib import Path

import pytest

from cosim.base.component import Causality, Cells, Component, Setup, Variable
from cosim.base.errors import InputError
from cosim.base.quantities.units import Unit, conversion, parse_unit, symbols, unit_of
from cosim.master.components.parameters import SETTABLE, resolve_values
from tests.support.master.master_support import run, scenario_of

ROOT = Path(__file__).parents[3]
SYMBOLS = [symbol for symbol in symbols() if symbol != "1"]
COMPOUND = ["N.s/m", "kg.m2", "N/(m.s)", "rpm/s", "km/h", "deg/s2", "mN.mm", "s-1", "m^2", "kg·m²"]
ANOTHER = {"m": "mm", "rad/s": "rpm", "rad": "deg", "K": "degC", "s": "h", "1": "%", "N": "kN"}


def as_parameter(spelling: str, unit: str) -> float | None:
    """The value 3 with a unit, for a parameter in ``unit``."""
    variable = Variable(name="p", causality=Causality.PARAMETER, unit=unit)
    try:
        values = resolve_values("c", {"p": variable}, "p", f"3 {spelling}", SETTABLE)
    except InputError:
        return None
    return values["p"][0]


def over_a_connection(spelling: str, unit: str) -> float | None:
    """The value 3 of an output in a unit, seen by an input in ``unit``."""
    found = conversion(unit_of(spelling), unit_of(unit))
    return None if found is None else found[0] * 3.0 + found[1]


@pytest.mark.parametrize("spelling", [*SYMBOLS, *COMPOUND])
def test_what_converts_in_one_place_converts_in_the_other(spelling: str):
    for unit in [*ANOTHER, *ANOTHER.values(), spelling]:
        one, other = as_parameter(spelling, unit), over_a_connection(spelling, unit)
        assert (one is None) == (other is None), (spelling, unit)
        if one is not None and other is not None:
            assert one == pytest.approx(
                other, rel=1e-15, abs=0.0 if "deg" not in spelling else 1e-9
            )


def test_both_refuse_what_is_no_unit_and_what_is_ambiguous():
    for spelling in ("furlong", "N/m.s", "degC/s", "N m", "k", "kmin", ""):
        assert unit_of(spelling).exponents is None
        assert as_parameter(spelling or "?", "m") is None


@pytest.mark.parametrize(("unit", "other"), ANOTHER.items())
def test_there_and_back_is_nothing(unit: str, other: str):
    there, back = (
        conversion(parse_unit(other), parse_unit(unit)),
        conversion(parse_unit(unit), parse_unit(other)),
    )
    assert there is not None
    assert back is not None
    assert (there, back) != ((1.0, 0.0), (1.0, 0.0))
    assert (7.0 * there[0] + there[1]) * back[0] + back[1] == pytest.approx(7.0, rel=1e-12)


def test_factors_are_rounded_once():
    exact = {"km/h": Fraction(5, 18), "mm2": Fraction(1, 10**6), "cm3": Fraction(1, 10**6)}
    for text, factor in exact.items():
        assert parse_unit(text).factor == factor
    assert conversion(parse_unit("deg"), parse_unit("rad")) == (math.pi / 180, 0.0)
    for small, large in product(("mm", "cm", "km"), repeat=2):
        gain = conversion(parse_unit(f"{small}3"), parse_unit(f"{large}3"))
        size = {"mm": -3, "cm": -2, "km": 3}
        assert gain == (float(Fraction(10) ** (3 * (size[small] - size[large]))), 0.0)


def test_a_unit_that_the_component_defines_counts_in_its_parameters_too():
    smoot = Unit("smoot", parse_unit("m").exponents, Fraction("1.7018"))
    variable = Variable(name="p", causality=Causality.PARAMETER, unit="smoot")
    for text, value in (("2 smoot", 2.0), ("1.7018 m", 1.0), ("1701.8 mm", 1.0)):
        found = resolve_values("c", {"p": variable}, "p", text, SETTABLE, units={"smoot": smoot})
        assert found == {"p": [value]}


class Spinner(Component):
    """Shows its speed in rpm and reads one in rad/s."""

    @property
    def variables(self) -> Sequence[Variable]:
        """A parameter, an input, two outputs."""
        return (
            Variable(name="set_speed", causality=Causality.PARAMETER, unit="rpm", start=0.0),
            Variable(name="heard", causality=Causality.INPUT, unit="rad/s"),
            Variable(name="speed", causality=Causality.OUTPUT, unit="rpm"),
            Variable(name="seen", causality=Causality.OUTPUT, unit="rad/s"),
        )

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Keep the cells."""
        self.inputs, self.outputs = inputs, outputs
        self.speed = setup.parameters["set_speed"]

    def evaluate(self, tick: int) -> None:
        """Show both."""
        self.outputs["speed"][0] = self.speed
        self.outputs["seen"][0] = self.inputs["heard"][0]


def test_a_connection_from_rpm_to_rad_per_second_converts(tmp_path: Path):
    scenario = scenario_of(
        tmp_path,
        f"""
        duration: 0.01
        rates: {{control: 1000}}
        components:
          a: {{python: "{__name__}:Spinner", parameters: {{set_speed: 1 rev/s}}}}
          b: {{python: "{__name__}:Spinner"}}
        connections:
          - a.speed -> b.heard
        """,
    )
    sink, simulation = run(scenario)
    assert any("rpm" in note for note in simulation.notes)
    assert sink.signal("a.speed")[-1] == 60.0
    assert sink.signal("b.seen")[-1] == pytest.approx(2 * math.pi, rel=1e-15)


def test_units_need_the_standard_library_alone():
    program = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "import cosim.base.quantities.units, fmus.description"
    )
    subprocess.run([sys.executable, "-I", "-S", "-c", program, str(ROOT)], check=True)
