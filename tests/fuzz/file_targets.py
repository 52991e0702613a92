"""What people and other processes write: device files, URLs, emulators' side channels, rings."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import Any

import numpy as np

from cosim.base.errors import InputError
from cosim.realtime.ring import Reader, Ring
from cosim.scenario import load as load_scenario
from hil.drivers.cobs.emulator import CobsBoard
from hil.emulation.links import PtyLink
from hil.emulation.server import Server
from hil.emulation.world import World
from hil.setup.address import parse
from hil.setup.device_file import DeviceFile, load
from hil.setup.device_file import parse as parse_file
from hil.setup.options import check_options
from hil.setup.registry import find, names
from tests.fuzz.script import Script
from tests.fuzz.wire import Rest
from tests.support.scratch import scratch_folder

WORDS = (
    *("driver", "preset", "serial", "date", "estop", "geometry", "joints", "home", "limits"),
    *("loosened", "workspace", "settings", "direction", "offset", "counts_per_turn", "drive"),
    *("gear", "torque_constant", "amplifier", "bias", "low", "high", "low_code", "high_code"),
    *("proximal", "distal", "base", "left", "right", "bottom", "top", "torque", "ramp_time"),
    *("haply", "quanser", "cobs", "mock", "confirmed", "nodes", "ports", "watchdog", "timeout"),
)


def device_file_values(data: bytes) -> None:
    """Any nesting of plain values is a device file, or refused with a sentence."""
    document_is_refused_or_right(_value(Script(data), 4))


def document_is_refused_or_right(document: object) -> None:
    """The claim about device files, for other makers of documents."""
    try:
        file = parse_file(document)
    except InputError:
        return
    _check_file(file)


def device_file_text(data: bytes) -> None:
    """Any bytes in a file are a device file, or refused with a sentence."""
    path = _folder() / "fuzzed.yaml"
    path.write_bytes(data)
    try:
        file = load(path)
    except InputError:
        return
    _check_file(file)


def scenario_text(data: bytes) -> None:
    """Any bytes in a file are a scenario, or refused with a sentence that names a place in it."""
    path = _folder() / "fuzzed_scenario.yaml"
    path.write_bytes(data)
    try:
        scenario = load_scenario(str(path))
    except InputError:
        return
    assert scenario.components


def _check_file(file: DeviceFile) -> None:
    for joint in file.joints:
        assert joint.direction in {1, -1}
        assert 0.0 < joint.quantum < 1.0
        for torque in (0.0, 0.05, -0.05):
            assert abs(joint.drive.sendable(torque)) <= abs(torque)
    assert file.limits.torque > 0.0
    assert 1.0 <= file.limits.ramp_time <= 2.0
    assert file.home is None or file.linkage.tip(file.home) is not None


def _value(script: Script, depth: int) -> Any:
    kind = script.number(8) if depth else 2 + script.number(6)
    match kind:
        case 0:
            return {_key(script): _value(script, depth - 1) for _ in range(script.number(8))}
        case 1:
            return [_value(script, depth - 1) for _ in range(script.number(4))]
        case 2:
            return WORDS[script.number(len(WORDS))]
        case 3:
            return script.number(65536) - 32768
        case 4:
            return float(np.frombuffer(script.take(8).ljust(8, b"\0"), "<f8")[0])
        case 5:
            return (True, False, None, 10**400, "", "\0")[script.number(6)]
        case 6:
            return script.number(2000) / 1000
        case _:
            return script.take(6).decode("latin-1")


def _key(script: Script) -> str:
    return WORDS[script.number(len(WORDS))] if script.number(8) else script.take(5).decode("latin1")


def device_url(data: bytes) -> None:
    """Any text is a URL of a device, or refused with a sentence."""
    text = data.decode("utf-8", "surrogateescape")
    try:
        address = parse(text)
        assert address.url == text
        assert "://" in text
        for kind in names():
            check_options(find(kind).options, address)
    except InputError:
        return


def side_channel(data: bytes) -> None:
    """An emulator answers any request, with an error where it makes no sense."""
    server, (theirs, ours) = _server()
    theirs.send(data[:4096] or b"\0")
    server._serve_control(ours)
    theirs.setblocking(False)
    answer = theirs.recv(65536)
    if data[:1] != b"s":
        assert isinstance(json.loads(answer), dict)


@functools.cache
def _server() -> Any:
    import socket

    path = scratch_folder("fuzz") / "control"
    server = Server(CobsBoard(World(Rest((1, 2)), lockstep=False)), PtyLink(), path, tick=1 / 1024)
    return server, socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def ring_file(data: bytes) -> None:
    """A spoiled ring is refused, or gives whole records only."""
    path = _folder() / "ring"
    script = Script(data)
    ring = Ring.create(2, 8, path)
    for record in range(script.number(20)):
        ring.write((record, -record))
    ring.close()
    content = bytearray(path.read_bytes())
    for _ in range(script.number(8)):
        place = script.number(len(content))
        content[place : place + 8] = script.take(8).ljust(8, b"\0")
    path.write_bytes(content[: script.number(1024)] if script.number(4) == 1 else content)
    try:
        spoiled = Ring(path)
    except FileNotFoundError:
        return
    try:
        reader = Reader(spoiled, oldest=True)
        values = reader.read()
        assert values.shape == (len(values), spoiled.cells)
        assert len(values) <= spoiled.capacity
    finally:
        spoiled.close()


@functools.cache
def _folder() -> Path:
    return scratch_folder("fuzz")


TARGETS = {
    each.__name__: each
    for each in (
        device_file_values,
        device_file_text,
        scenario_text,
        device_url,
        side_channel,
        ring_file,
    )
}
