"""Two stations in two network namespaces joined by a veth pair, against the simulated channel.

Needs root and iproute2: uv run python bench/link_namespaces.py --duration 60
Prints deadlines, counters, and how far the copies of the box drift apart, beside what
``cohaptic run`` predicts for one network sample each way.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

COHAPTIC = [sys.executable, "-c", "from cosim.cli import main; main()"]
ADDRESSES = {"station_a": "10.77.0.1", "station_b": "10.77.0.2"}


def run(*words: str) -> None:
    subprocess.run(words, check=True)


def namespaces(prefix: str) -> dict[str, str]:
    names = {station: f"{prefix}{station[-1]}" for station in ADDRESSES}
    for name in names.values():
        run("ip", "netns", "add", name)
    a, b = names.values()
    run("ip", "link", "add", f"{a}v", "type", "veth", "peer", "name", f"{b}v")
    for station, name in names.items():
        run("ip", "link", "set", f"{name}v", "netns", name)
        run("ip", "-n", name, "addr", "add", f"{ADDRESSES[station]}/24", "dev", f"{name}v")
        run("ip", "-n", name, "link", "set", f"{name}v", "up")
    return names


def report(folder: Path) -> dict:
    manifest = json.loads((folder / "manifest.json").read_text())
    summary = json.loads((folder / "summary.json").read_text())
    return {"deadlines": manifest["deadlines"], "link": manifest["link"], "summary": summary}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=60.0)
    parser.add_argument("--scenario", default="two_users_box")
    arguments = parser.parse_args()
    if os.geteuid() != 0:
        sys.exit("network namespaces need root")
    prefix = f"coh{os.getpid() % 10000}"
    names = namespaces(prefix)
    with tempfile.TemporaryDirectory() as scratch:
        root = Path(scratch)
        try:
            run(*COHAPTIC, "keygen", str(root / "key"))
            stations = []
            for station, name in names.items():
                other = next(s for s in ADDRESSES if s != station)
                stations.append(
                    subprocess.Popen(
                        [
                            *(
                                "ip",
                                "netns",
                                "exec",
                                name,
                                *COHAPTIC,
                                "station",
                                arguments.scenario,
                            ),
                            *("--as", station, "--listen", f"{ADDRESSES[station]}:47000"),
                            *("--peer", f"{ADDRESSES[other]}:47000", "--key", str(root / "key")),
                            *("--duration", str(arguments.duration), "--wait", "60", "--no-figure"),
                            *("--out", str(root / station), "--json"),
                        ],
                        stdout=subprocess.DEVNULL,
                    )
                )
            codes = [station.wait() for station in stations]
        finally:
            for name in names.values():
                run("ip", "netns", "del", name)
        print("exit statuses:", codes)
        for station in ADDRESSES:
            found = report(root / station)
            lateness = {k: v for k, v in found["deadlines"].items() if k != "histogram"}
            print(station, "deadlines:", lateness)
            print(station, "link:", json.dumps(found["link"]["peers"]))
        run(*COHAPTIC, "merge", *(str(root / s) for s in ADDRESSES), "--out", str(root / "merged"))
        print("\nThe simulated channel, one sample each way:")
        run(
            *(*COHAPTIC, "run", arguments.scenario, "--duration", str(arguments.duration)),
            *("--set", "channels.lan.each_way_delay=1"),
            *("--set", "channels.lan.round_trip_delay=null"),
            *("--no-figure", "--out", str(root / "simulated")),
        )


if __name__ == "__main__":
    main()
