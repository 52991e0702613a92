"""Two stations in real time, in two network namespaces joined by a veth pair, and what is expected.

    uv run python bench/link_namespaces.py --duration 60        (root and iproute2)
    uv run python bench/link_namespaces.py --loopback           (two processes on 127.0.0.1)

Runs the stations with cyclictest beside them; merges their records; simulates the same scenario
with every packet delayed as it was; and runs the same load without a network. Prints

- every deadline that was lost, by cause: the machine's (woken late, interrupted) or our own work's,
  and then whether the link's part was the longest;
- packets that came too late, by cause: kept by the network, or sent late by a station held up;
- how far the copies of the box are from what the simulated channel predicts.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from host import Host, compare, verdict

from cosim.record import open_run

COHAPTIC = [sys.executable, "-c", "from cosim.cli import main; main()"]
STATIONS = ("station_a", "station_b")
ADDRESSES = {"station_a": "10.77.0.1:47000", "station_b": "10.77.0.2:47000"}
LOOPBACK = {"station_a": "127.0.0.1:47810", "station_b": "127.0.0.1:47811"}
BOUND = 1e-9
"""Agreement of the copies with the prediction (m, rad) while no peer was given up."""


def run(*words: str, **more: Any) -> None:
    subprocess.run(words, check=True, **more)


def namespaces(prefix: str) -> dict[str, str]:
    names = {station: f"{prefix}{station[-1]}" for station in STATIONS}
    for name in names.values():
        run("ip", "netns", "add", name)
    a, b = names.values()
    run("ip", "link", "add", f"{a}v", "type", "veth", "peer", "name", f"{b}v")
    for station, name in names.items():
        host = ADDRESSES[station].partition(":")[0]
        run("ip", "link", "set", f"{name}v", "netns", name)
        run("ip", "-n", name, "addr", "add", f"{host}/24", "dev", f"{name}v")
        run("ip", "-n", name, "link", "set", f"{name}v", "up")
    return names


def beside(folders: list[Path], processes: list[subprocess.Popen], seconds: float) -> Host:
    """cyclictest from where all loops run: their records begin with their first tick."""
    while not all((folder / "run.h5").exists() for folder in folders):
        if all(process.poll() is not None for process in processes):
            break
        time.sleep(0.05)
    return Host(max(1.0, seconds - 1.0), threads=2)


def run_stations(
    root: Path, options: argparse.Namespace, names: dict[str, str]
) -> dict[str, float]:
    addresses = ADDRESSES if names else LOOPBACK
    processes = []
    for station in STATIONS:
        other = next(s for s in STATIONS if s != station)
        inside = ["ip", "netns", "exec", names[station]] if names else []
        command = [
            *(*inside, *COHAPTIC, "station", options.scenario, "--as", station),
            *("--listen", addresses[station], "--peer", addresses[other]),
            *("--key", str(root / "key"), "--duration", str(options.duration)),
            *("--wait", "120", "--no-figure", "--out", str(root / station), "--json"),
        ]
        with (root / f"{station}.txt").open("w") as said:
            processes.append(subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said))
    host = beside([root / s for s in STATIONS], processes, options.duration)
    codes = [process.wait() for process in processes]
    if codes != [0, 0]:
        said = "".join((root / f"{s}.txt").read_text() for s in STATIONS)
        sys.exit(f"the stations ended with {codes}:\n{said}")
    return host.close()


def run_control(
    root: Path, options: argparse.Namespace
) -> tuple[list[dict[str, Any]], dict[str, float]]:
    """The same two loops, each with both stations' models and no link."""
    folders = [root / f"control-{number}" for number in range(2)]
    command = [
        *(*COHAPTIC, "run", options.scenario, "--realtime", "--duration", str(options.duration)),
        *("--set", "expect=~", "--no-figure", "--json", "--out"),
    ]
    processes = [
        subprocess.Popen([*command, str(folder)], stdout=subprocess.DEVNULL) for folder in folders
    ]
    host = beside(folders, processes, options.duration)
    for process in processes:
        process.wait()
    return [manifest(folder)["deadlines"] for folder in folders], host.close()


def manifest(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "manifest.json").read_text())


def tell_deadlines(name: str, found: dict[str, Any]) -> None:
    causes = ", ".join(
        f"{cause} {each['misses']} ({each['seconds'] * 1e3:.1f} ms)"
        for cause, each in found["causes"].items()
    )
    machine = found.get("machine", {})
    print(f"{name}: {found['misses']} of {found['ticks']} deadlines lost: {causes}")
    print(
        f"  longest part of own work {found['longest_part'] or '-'}; caught up in "
        f"{found['caught_up']} ticks, farthest behind {found['farthest_behind'] * 1e3:.1f} ms, "
        f"slipped {found['slipped_periods']}, worst {found['worst'] * 1e3:.1f} ms"
    )
    work = {part: f"{each['mean'] * 1e6:.0f}" for part, each in found["work"].items()}
    print(f"  us a tick {work}; processor {machine.get('processor', 0) / found['ticks'] * 1e6:.0f}")
    print(
        f"  waited for a processor {machine.get('waited', 0) * 1e3:.1f} ms, page faults "
        f"{machine.get('page_faults', 0):.0f}, stolen {machine.get('stolen', 0):.2f} s"
    )


def by_own_work(found: dict[str, Any]) -> tuple[int, float]:
    """Misses by the link's part of a tick, and those that the host explains.

    What a host takes without saying so looks like own work. It takes from every part in proportion
    to its time, so the parts that have nothing to do with a network say how much that is.
    """
    link = {part for part in found["work"] if part.startswith("link_")}
    counts, work = found["longest_part"], found["work"]
    others = sum(count for part, count in counts.items() if part not in link)
    time_in_link = sum(work[part]["mean"] for part in link)
    time_in_others = sum(each["mean"] for part, each in work.items() if part not in link)
    inside = sum(count for part, count in counts.items() if part in link)
    return inside, others * time_in_link / time_in_others


def spread(both: float) -> float:
    """Two standard deviations of the difference of two counts of rare events: no difference."""
    return 2.0 * float(np.sqrt(both))


def tell_link(name: str, link: dict[str, Any]) -> dict[str, int]:
    totals = {"overdue": 0, "overdue_by_network": 0, "losses": 0}
    for peer in link["peers"].values():
        for stream in peer["streams"].values():
            for total in totals:
                totals[total] += stream[total]
        told = {
            channel: {fate: n for fate, n in stream.items() if n}
            for channel, stream in peer["streams"].items()
        }
        print(f"{name}: sent {peer['sent']}, round trip {peer['round_trip'] or 0} ns, {told}")
    return totals


def agreement(merged: Path, predicted: Path) -> tuple[float, float, int]:
    """Largest difference of the box's poses while both peers counted in full, and after a loss."""
    with open_run(merged) as real, open_run(predicted) as expected:
        weights = [n for g in real.groups.values() for n in g.signals if n.endswith(".weight")]
        reduced = np.max([np.asarray(real[n].values) < 1.0 for n in weights], axis=0)
        # The weights rise to one with the first packet; what counts is a peer given up later.
        begun = int(np.argmin(reduced))
        given_up = np.flatnonzero(reduced[begun:])
        until = begun + int(given_up[0]) if len(given_up) else len(reduced)
        worst, after = 0.0, 0.0
        for name in (n for g in expected.groups.values() for n in g.signals if "box_pose" in n):
            apart = np.abs(np.asarray(real[name].values) - np.asarray(expected[name].values))
            worst = max(worst, float(apart[:until].max()))
            after = max(after, float(apart.max()))
        return worst, after, len(reduced) - until


def drift(folder: Path) -> float:
    found = subprocess.run(
        [*COHAPTIC, "record", "summary", str(folder), "--json"],
        check=True,
        capture_output=True,
        text=True,
    )
    return float(json.loads(found.stdout)["measures"]["drift"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--scenario", default="two_users_box")
    parser.add_argument("--loopback", action="store_true")
    parser.add_argument("--no-control", action="store_true")
    options = parser.parse_args()
    if not options.loopback and os.geteuid() != 0:
        sys.exit("network namespaces need root; --loopback does without")
    names = {} if options.loopback else namespaces(f"coh{os.getpid() % 10000}")
    with tempfile.TemporaryDirectory() as scratch:
        root = Path(scratch)
        try:
            run(*COHAPTIC, "keygen", str(root / "key"), stdout=subprocess.DEVNULL)
            seen = run_stations(root, options, names)
        finally:
            for name in names.values():
                run("ip", "netns", "del", name)
        print(f"stations beside cyclictest: {verdict(seen)}; cyclictest in us: {seen}")
        in_link, allowed, lost, totals = 0, 0.0, 0, {}
        as_many = True
        for station in STATIONS:
            facts = manifest(root / station)
            tell_deadlines(station, facts["deadlines"])
            compare(station, facts["deadlines"], seen)
            for total, count in tell_link(station, facts["link"]).items():
                totals[total] = totals.get(total, 0) + count
            lost += facts["deadlines"]["misses"]
            own, elsewhere = by_own_work(facts["deadlines"])
            in_link, allowed = in_link + own, allowed + elsewhere
        if not options.no_control:
            control, seen = run_control(root, options)
            print(f"\nthe same loops without a network: {verdict(seen)}; cyclictest: {seen}")
            for number, found in enumerate(control):
                tell_deadlines(f"control {number}", found)
                compare(f"control {number}", found, seen)
            without = sum(c["misses"] for c in control)
            as_many = lost <= without + spread(lost + without)
            print(
                f"deadlines lost with the network {lost}, without {without}: "
                f"{'no' if as_many else 'A'} difference beyond two standard deviations"
            )
        folders = [str(root / s) for s in STATIONS]
        quiet = {"stdout": subprocess.DEVNULL}
        run(*COHAPTIC, "merge", *folders, "--out", str(root / "merged"), **quiet)
        measured = root / "merged" / "measured.yaml"
        if not measured.exists():
            sys.exit("a station joined late: there is no prediction from the first tick")
        subprocess.run(
            [
                *(*COHAPTIC, "run", str(root / "merged" / "scenario.resolved.yaml")),
                *("--with", str(measured), "--set", f"duration={options.duration}"),
                *("--no-figure", "--out", str(root / "predicted")),
            ],
            check=False,
            **quiet,
        )
        worst, after, ticks = agreement(root / "merged", root / "predicted")
        print(
            f"\nthe copies' drift {drift(root / 'merged') * 1e3:.4f} mm, predicted for the "
            f"measured delays {drift(root / 'predicted') * 1e3:.4f} mm"
        )
        print(f"largest difference from the prediction {worst:.3g} (bound {BOUND:g})")
        if ticks:
            print(f"a peer was given up: in the {ticks} ticks from then on {after:.3g}")
        by_network = in_link > allowed + spread(in_link + allowed)
        print(
            f"deadlines lost by the link's part of a tick: {in_link}, as many as the host takes "
            f"from the other parts: {allowed:.1f}; packets late on their way "
            f"{totals['overdue_by_network']}, sent late "
            f"{totals['overdue'] - totals['overdue_by_network']}"
        )
        good = as_many and not by_network and not totals["overdue_by_network"] and worst <= BOUND
        print("the claim holds" if good else "THE CLAIM DOES NOT HOLD")
        sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
