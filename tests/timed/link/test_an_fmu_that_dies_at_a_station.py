"""An FMU that ends its process at a station fails that station with a sentence, not the other."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.fmus.dying import dying

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the sentence is Linux's")
RATE = 128


def test_the_station_has_status_1_a_sentence_and_its_record(tmp_path: Path) -> None:
    fmu = dying(tmp_path, 3, "DoStep", "exit(0)", RATE)
    (tmp_path / "s.yaml").write_text(
        f"cohaptic: 1\nduration: 2\nrates: {{net: {RATE}}}\ncomponents:\n"
        f"  hand: {{fmu: hand, rate: {RATE}, station: a}}\n"
        f"  box: {{fmu: {fmu}, rate: {RATE}, station: b, parameters: {{p: text}}}}\n"
        "channels: {lan: {between: [a, b], rate: net, round_trip_delay: 4}}\n"
        "connections: [hand.position -> box.u via lan]\n"
    )
    with socket.socket(type=socket.SOCK_DGRAM) as a, socket.socket(type=socket.SOCK_DGRAM) as b:
        for each in (a, b):
            each.bind(("127.0.0.1", 0))
        ports = a.getsockname()[1], b.getsockname()[1]
    stations = {
        name: subprocess.Popen(
            [
                *(sys.executable, "-c", "from cosim.cli import main; main()", "station", "s.yaml"),
                *("--as", name, "--listen", f"127.0.0.1:{own}", "--peer", f"127.0.0.1:{other}"),
                *("--no-realtime", "--no-figure", "--wait", "60", "--out", name),
            ],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for name, own, other in (("a", *ports), ("b", *ports[::-1]))
    }
    said = {name: process.communicate(timeout=120)[1] for name, process in stations.items()}
    assert stations["a"].returncode == 0, said["a"]
    assert stations["b"].returncode == 1
    sentence = "box ended the process (exit status 0) in its step at tick 3 (0.0234375 s)"
    assert sentence in said["b"]
    manifest = json.loads((tmp_path / "b" / "manifest.json").read_text())
    assert manifest["exit"]["status"] == 1
    assert sentence in manifest["exit"]["message"]
