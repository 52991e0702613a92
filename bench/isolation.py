"""What ``isolate: process`` costs: the same scenario in process and apart, in one interleaved run.

    uv run python bench/isolation.py [--seconds 10] [--rounds 5]

Both simulations run in slices of 1024 ticks, one after the other, so that whatever else the machine
does hits both; in the end all variables must agree bit for bit. What is counted is wall time, since
two processes share the work: the machine has to be idle, with a processor for each of them.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from cosim.master.kernel.codes import OperationKind
from cosim.master.run.simulation import Simulation, assemble
from cosim.scenario import Scenario, load
from cosim.testing.ring import row_of_masses

SLICE = 1024
CALLS = (
    OperationKind.SET,
    OperationKind.SET_FLOAT64,
    OperationKind.GET,
    OperationKind.GET_FLOAT64,
    OperationKind.STEP,
    OperationKind.STEP_IN_PARTS,
)
CASES = (("ring:1", ("m0",)), ("ring:8", ("m0",)), ("two_users_box", ("finger_a1",)))
"""A scenario, and which of its components are apart."""


def chosen(name: str, apart: tuple[str, ...], seconds: str, folder: Path) -> Scenario:
    """The scenario with some components in processes of their own."""
    sets = [f"components.{part}.isolate=process" for part in apart]
    kind, _, size = name.partition(":")
    if kind != "ring":
        return load(name, sets=[f"duration={seconds}", *sets])
    file = folder / "ring.yaml"
    file.write_text(row_of_masses(int(size), ticks=round(1024 * float(seconds))))
    return load(file, sets=sets)


def calls(simulation: Simulation, apart: tuple[str, ...]) -> float:
    """How often the FMUs apart are called in a tick."""
    program = simulation.program
    numbers = {program.numbers[name] for name in apart}
    operations = zip(program.operations.all, program.operations.actions, strict=True)
    return sum(
        1 / action.period
        for number, (operation, action) in enumerate(operations)
        if number not in program.early and operation.owner in numbers
        if OperationKind(operation.kind) in CALLS
    )


def measure(name: str, apart: tuple[str, ...], seconds: str) -> tuple[float, float, float]:
    """Wall time (s) a tick in process and apart, and calls to those apart a tick."""
    with tempfile.TemporaryDirectory() as folder:
        scenarios = [chosen(name, each, seconds, Path(folder)) for each in ((), apart)]
    spent, ticks = [0.0, 0.0], scenarios[0].ticks
    with assemble(scenarios[0]) as here, assemble(scenarios[1]) as there:
        simulations = (here, there)
        for simulation in simulations:
            simulation.start(ticks)
        for end in (*range(SLICE, ticks, SLICE), ticks):
            for place, simulation in enumerate(simulations):
                began = time.perf_counter()
                simulation.advance(end)
                spent[place] += time.perf_counter() - began
        if not np.array_equal(here.program.cells, there.program.cells):
            raise SystemExit("the two do not agree: the comparison is void")
        return spent[0] / ticks, spent[1] / ticks, calls(there, apart)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seconds", default="10")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    print(f"{options.seconds} s, slices of {SLICE} ticks, least of {options.rounds} rounds")
    print(f"{'':24}{'apart':>12}{'in process':>12}{'isolated':>12}{'calls':>8}{'us a call':>12}")
    for name, apart in CASES:
        rounds = [measure(name, apart, options.seconds) for _ in range(options.rounds)]
        here, there = (1e6 * min(each[place] for each in rounds) for place in (0, 1))
        count = rounds[0][2]
        print(
            f"{name:24}{','.join(apart):>12}{here:9.2f} us{there:9.2f} us{count:8.2f}"
            f"{(there - here) / count:12.3f}"
        )


if __name__ == "__main__":
    main()
