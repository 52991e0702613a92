"""What the fuzzer begins with where random bytes would never get past the first check."""

from __future__ import annotations

import zlib

DEVICE_FILE = b"""cohaptic_device: 1
driver: canopen
preset: quanser
serial: "5573"
date: 2026-03-01
estop: confirmed
geometry: {proximal: 0.1, distal: 0.165, base: 0.085}
home: [2.427, 0.714]
joints:
  - {direction: 1, offset: 0.1, counts_per_turn: 4880, drive: {gear: 2, torque_constant: 0.03}}
  - {direction: -1, drive: {amplifier: 0.5, bias: 0.01, low: -6, high: 6, low_code: 0}}
limits: {torque: 0.1, ramp_time: 2}
loosened: {torque: because}
workspace: {left: -0.1, right: 0.1, bottom: 0.05, top: 0.2}
settings: {nodes: [1, 2], watchdog: {timeout: 0.02}}
"""
SCENARIO = b"""cohaptic: 1
title: One hand
duration: 1
seed: 7
rates: {control: 1024, network: 128}
components:
  finger: {fmu: pantograph, station: a, rate: control, parameters: {finger_mass: 0.1}}
  hand: {fmu: operator, station: b, rate: control, parameters: {initial_position: [0, 0.1]}}
channels:
  lan: {between: [a, b], rate: network, round_trip_delay: 1, jitter: 2 ms, loss: 0.1}
connections:
  - finger.tip_position -> hand.position via lan
  - {from: hand.force, to: finger.hand_force, via: lan}
record: [finger.*]
expect: {finger.energy: {max_abs_below: 0.06}}
"""
SEEDS: dict[str, tuple[bytes, ...]] = {
    "device_file_text": (
        DEVICE_FILE,
        b"driver: haply\n",
        b"{driver: mock, home: [1e3, .nan]}",
        b"{[1, {a: b}]: 2}",
    ),
    "scenario_text": (SCENARIO, b"cohaptic: 1\na: {[1, {b: c}]: 2}\n"),
    "device_url": (
        b"haply:///dev/ttyACM0",
        b"odrive+socketcan://can0?nodes=0,1&budget=0.001",
        b"cobs+rfc2217://host:1?a=%41&lockstep=1",
    ),
    "side_channel": (
        b'{"do": "fault", "kind": "drop", "start": 3, "ticks": 1, "bit": 2}',
        b'{"do": "shift", "by": [0.1, 0.2]}',
        b'{"do": "state"}',
        b"s\0\0\0\0\0\0\0\0",
    ),
    "slcan_lines": (b"t0298001122334455667\r", b"t0090\rr0090\r\aT00000001122\r"),
    "contracts": (b'{"rate": "128"}', zlib.compress(b'{"rate": "127"}'), b"["),
    "key_files": (b"cohaptic-key-1 " + b"A" * 43 + b"=\n",),
    "canopen_frames": (b"\5", bytes(8), bytes.fromhex("43001800aabbccdd"), b"\x80" + bytes(7)),
    "odrive_frames": (bytes(8), b"\0\0\x80\x3f\0\0\0\x40"),
    "haply_reply": (b"\x05\0\0\x80\x3f\0\0\0\x40",),
}
