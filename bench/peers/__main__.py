"""The same FMUs in other masters, first compared and then timed.

    uv run python bench/peers [--sizes 8 64 512 4096] [--rounds 3] [--plot peers.svg]

Rings and chains of masses, at one rate and with every other one at an eighth of it, and the ten
FMUs of ``two_users_box``; with and without a record of what is watched. Peers are installed into an
environment of their own in the cache, as the registry has them; MasterSim is in none, so that
``--mastersim`` gives its program. Every run of a peer is a process of its own, rounds are
interleaved, and what is printed are microseconds a tick and the ratio to a bare C loop over the
same FMUs, which writes a binary log where the others record. A peer whose last values are not ours,
bit for bit, is shown as such; exit status 1 where one differs that is known to agree.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # kernel.py and rings.py, beside this folder

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


def main() -> int:
    options = arguments().parse_args()
    peers = [PEERS[name] for name in options.peers]
    if options.mastersim:
        peers.append(PEERS["mastersim"])
    python = environment(peers)
    rows: list[Row] = []
    wrong: set[str] = set()
    with tempfile.TemporaryDirectory() as name:
        for case in cases(options.sizes, options.ticks, Path(name)):
            for recorded in (False, True):
                title = f"{case.name}, {'recorded' if recorded else 'no record'}"
                ticks = case.scenario.ticks
                print(f"{title}: {case.size} FMUs, {ticks} ticks, {options.rounds} rounds")
                found = compare(case, peers, python, options, Path(name), recorded=recorded)
                printed(found)
                rows += found
                expected = {peer.name for peer in peers if case.kind in peer.computes}
                wrong |= {
                    f"{row.who} in {case.name}: {row.remark}"
                    for row in found
                    if row.who in expected and row.remark and row.microseconds
                }
    if options.plot:
        drawn(rows, options.plot)
    for each in sorted(wrong):
        print(f"known to compute the same: {each}", file=sys.stderr)
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


def compare(
    case: Case,
    peers: list[Peer],
    python: Path,
    options: argparse.Namespace,
    folder: Path,
    *,
    recorded: bool,
) -> list[Row]:
    """Everybody in turn, ``options.rounds`` times; the least of each."""
    system, expected = last_values(case.scenario)
    given = system.write(folder / "system.json")
    seconds: dict[str, list[float]] = {}
    remarks: dict[str, str] = {}
    for number in range(options.rounds):
        master, bare = times(case.scenario, recorded=recorded)
        seconds.setdefault(BARE, []).append(bare)
        seconds.setdefault("cohaptic", []).append(master)
        for peer in peers:
            name = peer.name
            if name in remarks and name not in seconds:
                continue  # it could not, and will not
            record = folder / f"{name}-{number}-{case.name}-{case.size}" if recorded else None
            answer = ask(python, peer, given, record, options.mastersim)
            remarks |= {name: why} if (why := different(answer, expected, peer.digits)) else {}
            if not answer.cannot:
                seconds.setdefault(name, []).append(answer.seconds)
    rows: list[Row] = []
    for name in (BARE, "cohaptic", *(peer.name for peer in peers)):
        least = min(seconds.get(name, [0.0])) / case.scenario.ticks * 1e6
        title = f"{case.name}, {'recorded' if recorded else 'no record'}"
        ratio = least / (min(seconds[BARE]) / case.scenario.ticks * 1e6)
        rows.append(Row(title, case.size, name, least, ratio, remarks.get(name, "")))
    return rows


def different(answer: Answer, expected: dict[str, float], digits: int) -> str:
    """What is to be said of an answer; nothing where it is ours in all the digits that it has."""
    if answer.cannot:
        return answer.cannot
    for (name, ours), theirs in zip(expected.items(), answer.values, strict=True):
        if float(f"{ours:.{digits}g}") != theirs:
            return f"differs: {name} is {theirs!r}, here {ours!r}"
    return ""


if __name__ == "__main__":
    sys.exit(main())
