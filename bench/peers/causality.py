"""What a value that crosses a join has missed, in each master: asked of FMUs that tell their tick.

    uv run python bench/peers/causality.py [--mastersim PROGRAM]

Probes (``fmus.probe``) give the tick at which they are, and tell which tick they heard when their
last step began. One whose step begins at tick k and that heard k is told what holds then; one
that heard k - 1 is a tick late; one that heard more than k was told the future.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # kernel.py, which here.py asks for

from here import last_values
from peer import PEERS, ask, environment
from systems import RATE, SLOW

from cosim.scenario import Scenario, load
from fmus.probe import find

LAST = 15
"""The tick at which the last step begins whose hearing is asked for."""
FIRST = 100
"""The sender's tick at the start, so that it is told apart from a start value."""


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--mastersim", default="", metavar="PROGRAM")
    options = parser.parse_args()
    # FMPy's API is no master: what its loop hands over when is ours.
    masters = [
        peer
        for key, peer in PEERS.items()
        if key != "fmpy" and (key != "mastersim" or options.mastersim)
    ]
    python = environment(masters)
    table: dict[str, list[str]] = {
        name: [] for name in ("cohaptic", *(peer.name for peer in masters))
    }
    with tempfile.TemporaryDirectory() as name:
        for number, (_, written, begun) in enumerate(questions(Path(name))):
            system, ours = last_values(written)
            given = system.write(Path(name) / f"{number}.json")
            table["cohaptic"].append(said(next(iter(ours.values())), begun))
            for master in masters:
                answer = ask(python, master, given, None, options.mastersim)
                why = answer.cannot or answer.failed
                table[master.name].append(why or said(answer.values[0], begun))
        titles = [title for title, _, _ in questions(Path(name))]
    print("| | " + " | ".join(titles) + " |")
    print("|" + "---|" * (len(titles) + 1))
    for master, cells in table.items():
        print(f"| {master} | " + " | ".join(cells) + " |")
    return 0 if table["cohaptic"] == ["at once"] * len(titles) else 1


def said(heard: float, begun: int) -> str:
    """In words, what was heard by a step that began at tick ``begun``."""
    late = begun - int(heard)
    if heard < 0:
        return "not at all"
    if late == 0:
        return "at once"
    return f"{late} ticks late" if late > 0 else f"{-late} ticks early"


def questions(folder: Path) -> list[tuple[str, Scenario, int]]:
    """Title, scenario, and the tick at which the receiver's last step began."""
    told = {"first_tick": FIRST}
    fast, slow = {}, {"rate": RATE // SLOW}
    slow_told = told | {"period": SLOW}
    chain = [
        {"from": "a.tick", "to": "b.heard"},
        {"from": "b.seen", "to": "c.heard"},
        {"from": "c.seen", "to": "d.heard"},
    ]
    one = [{"from": "a.tick", "to": "b.heard"}]
    of_b, of_d = "b.last_heard", "d.last_heard"
    return [
        (
            "the first value",
            probes(folder, 2, {"a": (fast, told), "b": (fast, {})}, one, of_b),
            FIRST,
        ),
        (
            "one join",
            probes(folder, LAST + 2, {"a": (fast, told), "b": (fast, {})}, one, of_b),
            FIRST + LAST,
        ),
        (
            "through two feedthroughs",
            probes(
                folder,
                LAST + 2,
                {"a": (fast, told), "b": (fast, {}), "c": (fast, {}), "d": (fast, {})},
                chain,
                of_d,
            ),
            FIRST + LAST,
        ),
        (
            "fast to slow",
            probes(folder, LAST + 2, {"a": (fast, told), "b": (slow, {})}, one, of_b),
            FIRST + SLOW,
        ),
        *(
            (
                f"slow to fast, {where}",
                probes(folder, begun + 2, {"a": (slow, slow_told), "b": (fast, {})}, one, of_b),
                FIRST + begun // SLOW * SLOW,
            )
            for where, begun in (("between its steps", LAST), ("at its step", LAST + 1))
        ),
    ]


def probes(
    folder: Path,
    ticks: int,
    parts: dict[str, tuple[dict[str, int], dict[str, int]]],
    joined: list[dict[str, str]],
    recorded: str,
) -> Scenario:
    common = {"fmu": str(find("probe_tick", "fmi2")), "rate": RATE, "feedthrough": True}
    written = {
        "cohaptic": 1,
        "duration": f"{ticks}/{RATE}",
        "components": {
            name: common | more | {"parameters": parameters}
            for name, (more, parameters) in parts.items()
        },
        "connections": joined,
        "record": [recorded],
    }
    file = folder / "probes.yaml"
    file.write_text(json.dumps(written))
    return load(file)


if __name__ == "__main__":
    sys.exit(main())
