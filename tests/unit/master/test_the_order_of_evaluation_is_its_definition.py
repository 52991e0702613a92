"""The order of evaluation is found by a heap, and is the one that its definition gives."""

from __future__ import annotations

import random
import time

import pytest

import cosim.master.assembly.plan as planning
from cosim.analysis import load_tuned
from cosim.master.assembly.assemble import put_together
from cosim.master.assembly.ordering import Atom, Graph, Stage, Unit, order
from cosim.scenario.source.find import bundled_folder
from tests.support.master.ordering_by_scanning import order_by_scanning

GRAPHS = 12_000
SCENARIOS = bundled_folder()
BUNDLED = sorted(
    path.relative_to(SCENARIOS).with_suffix("").as_posix()
    for folder in (SCENARIOS, SCENARIOS / "thesis")
    for path in folder.glob("*.yaml")
)


def random_graph(draw: random.Random) -> Graph:
    """Up to nine units (components and bundles), of up to five atoms, with any density of needs."""
    units: list[Unit] = [*(f"unit_{n}" for n in range(draw.randint(1, 7)))]
    units += range(draw.randint(0, 2))
    atoms: list[Atom] = []
    for unit in units:
        count = draw.choice((1, 1, 2, 3, 5))
        atoms += [(unit, n if isinstance(unit, int) else f"out_{n}") for n in range(count)]
    draw.shuffle(atoms)
    density = draw.choice((0.5, 1.0, 2.0, 3.0)) / len(atoms)
    may_loop = draw.random() < 0.2
    needs: dict[Atom, dict[Atom, str | None]] = {}
    for place, atom in enumerate(atoms):
        others = atoms if may_loop else atoms[:place]
        needs[atom] = {other: "in" for other in others if draw.random() < density}
    shuffled = list(needs)
    draw.shuffle(shuffled)
    return Graph({atom: needs[atom] for atom in shuffled})


def test_random_graphs_are_ordered_as_the_definition_says() -> None:
    draw = random.Random(20_260_101)
    loops = splits = 0
    for _ in range(GRAPHS):
        graph = random_graph(draw)
        found = order(graph)
        assert found == order_by_scanning(graph)
        stages = [item.unit for item in found if isinstance(item, Stage)]
        loops += not stages
        splits += len(stages) > len(set(stages))
    assert loops > 500, "algebraic loops were among them"
    assert splits > 500, "units that had to be split were among them"


@pytest.fixture
def compared(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Every graph that a planner orders is ordered by the definition, too."""
    sizes: list[int] = []

    def both(graph: Graph) -> list[Stage] | list[Atom]:
        found = order(graph)
        assert found == order_by_scanning(graph)
        sizes.append(len(graph.needs))
        return found

    monkeypatch.setattr(planning, "order", both)
    return sizes


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_scenarios_are_ordered_as_the_definition_says(
    name: str, compared: list[int]
) -> None:
    put_together(load_tuned(name))
    assert compared, "the planner ordered something"


def split_ring(count: int) -> Graph:
    """Each unit's first output needs the second of the unit before it, all round."""
    needs: dict[Atom, dict[Atom, str | None]] = {}
    for number in range(count):
        unit, before = f"unit_{number}", f"unit_{(number - 1) % count}"
        needs[unit, "late"] = {(before, "early"): "in"}
        needs[unit, "early"] = {}
    return Graph(needs)


@pytest.mark.parametrize("kind", ["ring of split units", "chain"])
def test_ordering_grows_with_the_number_of_units(kind: str) -> None:
    def graph(count: int) -> Graph:
        if kind == "chain":
            names: list[Atom] = [(f"unit_{n}", "out") for n in range(count)]
            behind = {names[n]: {names[n - 1]: None} if n else {} for n in range(count)}
            return Graph(behind)
        return split_ring(count)

    assert order(graph(64)) == order_by_scanning(graph(64))
    times: list[float] = []
    for count in (1_000, 8_000):
        subject = graph(count)
        times.append(min(_seconds(subject) for _ in range(5)))
    # Caches that no longer hold it all cost a factor; the square would cost 64.
    assert times[1] < 8 * times[0] * 5, "eight times the units in far less than the square"


def _seconds(graph: Graph) -> float:
    began = time.process_time()
    order(graph)
    return time.process_time() - began
