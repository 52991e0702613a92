"""The same FMUs in other masters, first compared and then timed.

    uv run python bench/peers [--sizes 8 64 512 4096] [--rounds 3] [--plot peers.svg]

Rings and chains of masses, at one rate and with every other one at an eighth of it, and the ten
FMUs of ``two_users_box``; with and without a record of what is watched. Peers are installed into an
environment of their own in the cache, as the registry has them; MasterSim is in none, so that
``--mastersim`` gives its program. Every run of a peer is a process of its own, rounds are
interleaved, and what is printed are microseconds a tick and the ratio to a bare C loop over the
same FMUs, which writes a binary log where the others record. A peer whose last values are not ours,
bit for bit, is shown as such; exit status 1 where one that is known to agree differs or fails.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # kernel.py, beside this folder

from here import last_values, times
from peer import PEERS, Answer, Peer, ask, environment
from systems import SHAPES, masses, two_users
from table import BARE, Row, drawn, printed

from cosim.scenario import Scenario

WORK = 2**16
"""Steps of FMUs in a run, where no other number of ticks is asked for."""


@dataclass(frozen=True)
class Case:
    """One system that everybody runs."""

    kind: str
    name: str
    size: int
    scenario: Scenario


@dataclass(frozen=True)
class Asked:
    """Whom, in which Python, about which system, and what we give for it."""

    python: Path
    peers: list[Peer]
    system: Path
    expected: dict[str, float]
    mastersim: str


def main() -> int:
    options = arguments().parse_args()
    peers = [PEERS[name] for name in options.peers]
    if options.mastersim:
        peers.append(PEERS["mastersim"])
    python = environment(peers)
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        for case in cases(options.sizes, options.ticks, Path(name)):
            system, expected = last_values(case.scenario)
            given = system.write(Path(name) / "system.json")
            asked = Asked(python, peers, given, expected, options.mastersim)
            for recorded in (False, True):
                title = f"{case.name}, {'recorded' if recorded else 'no record'}"
                ticks = case.scenario.ticks
                print(f"{title}: {case.size} FMUs, {ticks} ticks, {options.rounds} rounds")
                found = compare(case, title, asked, options.rounds, recorded=recorded)
                printed(found)
                rows += found
    if options.plot:
        drawn(rows, options.plot)
    wrong = [row for row in rows if row.is_wrong]
    for row in wrong:
        print(
            f"known to compute the same: {row.who} in {row.system}: {row.remark}", file=sys.stderr
        )
    return 1 if wrong else 0


def arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bench/peers", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--sizes", nargs="+", type=int, default=[8, 64])
    parser.add_argument("--ticks", type=int, help=f"default: {WORK} / size, 64 to 4096")
    parser.add_argument("--rounds", type=int, default=3)
    known = [name for name in PEERS if name != "mastersim"]
    parser.add_argument("--peers", nargs="*", choices=known, default=known)
    parser.add_argument("--mastersim", default="", metavar="PROGRAM")
    parser.add_argument("--plot", type=Path, metavar="FILE")
    return parser


def cases(sizes: list[int], ticks: int | None, folder: Path) -> Iterator[Case]:
    for mixed, kind in ((False, "one rate"), (True, "two rates")):
        for shape in SHAPES:
            for size in sizes:
                count = ticks or max(64, min(4096, WORK // size))
                written = masses(shape, size, count, folder, mixed=mixed)
                yield Case(kind, f"{shape}, {kind}", size, written)
    yield Case("two users", "two users", 10, two_users(ticks or 4096))


def compare(case: Case, title: str, asked: Asked, rounds: int, *, recorded: bool) -> list[Row]:
    """Everybody in turn, ``rounds`` times; the least of each."""
    seconds: dict[str, list[float]] = {}
    remarks: dict[str, str] = {}
    wrong: set[str] = set()
    for number in range(rounds):
        master, bare = times(case.scenario, recorded=recorded)
        seconds.setdefault(BARE, []).append(bare)
        seconds.setdefault("cohaptic", []).append(master)
        for peer in asked.peers:
            name = peer.name
            if name in remarks and name not in seconds:
                continue  # it could not, and will not
            record = asked.system.with_name(f"{name}-{number}-{title}") if recorded else None
            answer = ask(asked.python, peer, asked.system, record, asked.mastersim)
            differs = answer.failed or different(answer, asked.expected, peer.digits)
            if differs or answer.cannot:
                remarks[name] = differs or answer.cannot
            if differs and case.kind in peer.computes:
                wrong.add(name)
            if answer.seconds:
                seconds.setdefault(name, []).append(answer.seconds)
    base = min(seconds[BARE])
    return [
        Row(
            system=title,
            size=case.size,
            who=name,
            microseconds=(least := min(seconds.get(name, [0.0]))) / case.scenario.ticks * 1e6,
            ratio=least / base,
            remark=remarks.get(name, ""),
            is_wrong=name in wrong,
        )
        for name in (BARE, "cohaptic", *(peer.name for peer in asked.peers))
    ]


def different(answer: Answer, expected: dict[str, float], digits: int) -> str:
    """What a peer gives otherwise than we; nothing where it gives the same in all its digits."""
    if answer.cannot:
        return ""
    for (name, ours), theirs in zip(expected.items(), answer.values, strict=True):
        if float(f"{ours:.{digits}g}") != theirs:
            return f"differs: {name} is {theirs!r}, here {ours!r}"
    return ""


if __name__ == "__main__":
    sys.exit(main())
