"""Broken inputs, each a mistake that somebody makes, as changes to a scenario that is right.

A case changes the text of ``BASE`` (or brings files, an overlay, ``--set``); what it was changed
from is its valid sibling.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import fmus

BASE = """\
cohaptic: 1
title: A hand pulls through a network
duration: 20 ms
seed: 1
rates: {control: 1024, network: 128}
components:
  pull: {fmu: signal, station: a, rate: control, parameters: {mode: step, amplitude: 0.1}}
  hand: {fmu: hand, station: a, rate: control, parameters: {mass: 100 g}}
  coupler: {fmu: virtual_coupler, station: b, rate: control, parameters: {stiffness: 200}}
  object: {fmu: object, station: b, rate: control}
channels:
  lan: {between: [a, b], rate: network, round_trip_delay: 1, loss: 0.01}
connections:
  - pull.value -> hand.force
  - hand.position -> coupler.position_a via lan
  - hand.velocity -> coupler.velocity_a via lan
  - object.position -> coupler.position_b
  - object.velocity -> coupler.velocity_b
  - coupler.force -> object.force[1]
  - coupler.reaction -> hand.coupler_force via lan
record: [hand.*, object.position, lan.forward.age]
expect: {hand.position: {max_abs_below: 10 m}}
"""
BENCH = """\
cohaptic: 1
duration: 20 ms
components:
  finger: {device: {url: "mock://", file: device.yaml}, rate: 1024}
record: [finger.joint_angle]
"""
DEVICE = """\
driver: mock
preset: quanser
geometry: {proximal: 0.1, distal: 0.165, base: 0.085}
joints: [{direction: 1, counts_per_turn: 20000}, {direction: -1, counts_per_turn: 20000}]
limits: {torque: 0.1}
"""
COMPONENT = """\
from cosim.base.component import Causality, Component, Variable


class Guest(Component):
    @property
    def variables(self):
        return (Variable(name="out", causality=Causality.OUTPUT, unit="m"),)

    def initialise(self, setup, inputs, outputs):
        outputs["out"][0] = 0.0
"""
GUEST = """\
cohaptic: 1
duration: 20 ms
components:
  guest: {python: "MODULE:Guest", rate: 1024}
record: [guest.out]
"""
FOREIGN = """\
cohaptic: 1
duration: 20 ms
components:
  hand: {fmu: foreign.fmu, rate: 1024}
record: [hand.position]
"""


Files = dict[str, str | Callable[[Path], None]]
"""Text, or what writes the file."""


@dataclass(frozen=True)
class Case:
    name: str
    text: str
    right: str
    sets: tuple[str, ...] = ()
    overlay: str | None = None
    files: Files = field(default_factory=dict)
    right_files: Files = field(default_factory=dict)


def place(folder: Path, text: str, files: Files) -> Path:
    """Write a case's files; returns the scenario's."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        if callable(content):
            content(folder / name)
        else:
            (folder / name).write_text(content, encoding="utf-8")
    file = folder / "s.yaml"
    file.write_text(text, encoding="utf-8")
    return file


# What stands in BASE, and what is written in its place.
CHANGES: dict[str, tuple[str, ...]] = {
    "cohaptic: 1": ("", "cohaptic: 2", "cohaptic: '1'", "cohaptik: 1"),
    "duration: 20 ms": (
        *(
            "",
            "duration: soon",
            "duration: -1 s",
            "duration: 0",
            "duration: .nan",
            "duration: .inf",
        ),
        *(
            "duration: 20 mm",
            "duration: {a: 1}",
            "duration: true",
            "duration: 1,5 s",
            "durations: 1",
        ),
        "duration: 1e12 s",
    ),
    "seed: 1": ("seed: x", "seed: 1.5", "seed: -1", "seed: .nan", "seed: [1]"),
    "control: 1024": (
        *("control: 0", "control: -1024", "control: 1024 s", "control: .inf", "control: fast"),
        *("contrl: 1024", "control: ~", "control: []"),
    ),
    "network: 128}": ("network: 0}", "network: 128 m}", "netwrk: 128}", "network: .nan}"),
    "fmu: signal": (
        *("fmu: signl", "fmu: nowhere.fmu", "fmu: 7", "fmu: ''", "fm: signal", "fmu: /", "fmu: ~"),
        *("fmu: signal, python: 'a:B'", "python: 'no_such_module:Thing'", "python: signal"),
        *("device: 'nodriver://x'", "device: mock", "playback: nowhere", "table: nowhere.csv"),
    ),
    "mode: step": ("mode: stp", "mode: 99", "mode: 1.5", "mode: true", "mod: step", "mode: [step]"),
    "amplitude: 0.1": (
        *(
            "amplitude: big",
            "amplitude: .nan",
            "amplitude: [1, 2]",
            "amplitude: 1 s",
            "amplitud: 1",
        ),
        *("amplitude: true", "amplitude: {x: 1}"),
    ),
    "mass: 100 g": (
        *("mass: 0", "mass: -1", "mass: 100 m", "mass: .nan", "mass: ~", "mas: 1", "mass: heavy"),
        *("force: 1", "position: 0", "initial_position: [1, 2]"),
    ),
    "stiffness: 200": ("stiffness: -5", "stifness: 200", "stiffness: 200 N", "stiffness: 'stiff'"),
    "station: b, rate: control, parameters": (
        *("station: [b], rate: control, parameters", "station: b, rate: contrl, parameters"),
        *("station: b, rate: -5, parameters", "station: c, rate: control, parameters"),
        *("station: b, parameters", "stations: b, rate: control, parameters"),
        "station: b, rate: control, flavour: fmi9, parameters",
        "station: b, rate: control, substeps: 0, parameters",
        "station: b, rate: control, substeps: 1.5, parameters",
        "station: b, rate: control, feedthrough: perhaps, parameters",
        "station: b, rate: control, start: {nothing: 1}, parameters",
        "station: b, rate: control, start: {position_a: x}, parameters",
        "station: b, rate: control, start: {position_a: .nan}, parameters",
        "station: b, rate: control, start: {stiffness: 1}, parameters",
        "station: b, rate: control, include: nowhere.yaml, parameters",
    ),
    "between: [a, b]": (
        "between: [a, c]",
        "between: [a]",
        "between: [a, a]",
        "between: a",
        "betwen: [a, b]",
    ),
    "rate: network, round": (
        "rate: netwrk, round",
        "rate: 0, round",
        "rate: 127.5 m, round",
        "round",
    ),
    "round_trip_delay: 1": (
        *("round_trip_delay: -1", "round_trip_delay: 1.5", "round_trip_delay: 3 m"),
        *("round_trip_delay: .nan", "round_trip_dely: 1", "round_trip_delay: soon"),
        *("round_trip_delay: 1, each_way_delay: 1", "delay: {forward: 1}", "round_trip_delay: 1/0"),
    ),
    "loss: 0.01": (
        *(
            "loss: 1.5",
            "loss: -0.1",
            "loss: .nan",
            "loss: 5 ms",
            "loss: {good_to_bad: 2}",
            "los: 0.1",
        ),
        *(
            "jitter: {rms: -1 ms}",
            "jitter: {weights: []}",
            "jitter: {weights: [-1, 2]}",
            "jitter: x",
        ),
        *("reorder: 2", "duplication: -1", "trace: [a]", "trace: nowhere.csv", "trace: []"),
        *("link: {delay: 0}", "link: {dely: 1}", "link: {clock: sideways}", "link: {fade: 3 m}"),
        *("link: {release: never}", "link: 7", "link: {hold_samples: 1.5}"),
    ),
    "- pull.value -> hand.force": (
        *("- pull.valu -> hand.force", "- pul.value -> hand.force", "- pull.value -> hand.forc"),
        *("- pull.value hand.force", "- hand.force -> pull.value", "- pull.value -> hand.mass"),
        *("- pull.value -> hand.force via lan", "- pull.value -> hand.force via wan", "- 7", "- ~"),
        *("- {from: pull.value}", "- {from: pull.value, to: hand.force, delay: -1}"),
        *("- {from: pull.value, to: hand.force, rate: 0}", "- pull.value: hand.force"),
        "- {from: pull.value, to: hand.force, initial: later}",
        "- pull.value -> hand.force\n  - pull.value -> hand.force",
    ),
    "- hand.position -> coupler.position_a via lan": (
        "- hand.position -> coupler.position_a",
        "- hand.position -> coupler.velocity_a via lan",
        "- hand.position -> object.force[2] via lan",
    ),
    "object.force[1]": ("object.force[0]", "object.force[18]", "object.force[x]", "object.forc[1]"),
    "record: [hand.*,": (
        *(
            "record: [hnd.*,",
            "record: [hand.z*,",
            "record: [7,",
            "record: [~,",
            "record: hand.*\n#",
        ),
        *("record: [{signals: hand.*, rate: 0},", "record: [{signal: hand.*},", "record: ['',"),
        "record: [lan.sideways.age,",
    ),
    "expect: {hand.position": (
        "expect: {hand.positon",
        "expect: {nothing",
        "expect: {coupler.force",
        "expct: {hand.position",
    ),
    "max_abs_below: 10 m": (
        *(
            "max_abs_belo: 10",
            "max_abs_below: 10 s",
            "max_abs_below: [1, 2]",
            "max_abs_below: .nan",
        ),
        *(
            "within: 1",
            "within: [2, 1]",
            "max_abs_below: 1, from: 9 s",
            "max_abs_below: ~",
            "from: 0",
        ),
        *("amplitude_below: 1", "amplitude_below: 1, frequency: x", "max_abs_below: 1, to: -1"),
    ),
}
SETS = (
    *(
        "components.hand.parameters.mas=1",
        "components.hnd.parameters.mass=1",
        "duration=x",
        "nothing",
    ),
    *("=1", "components.hand.parameters.mass=", "channels.lan.loss=2", "connections.99.from=a.b"),
    *(
        "channels.wan.loss=0.1",
        "components.hand.parameters.mass=[1",
        "record.7=hand.*",
        "seed=1e99",
    ),
    *("components.hand=7", "rates.control=0", "components.hand.rate=nope", "expect=5"),
)
OVERLAYS = (
    *(
        "7\n",
        "[1, 2]\n",
        "components: 5\n",
        "components: {hand: {parameters: {mas: 1}}}\n",
        "{a: b\n",
    ),
    *("cohaptic: 9\n", "connections: [{remove: hand.forc}]\n", "connections: 5\n", "nonsense: 1\n"),
    *("components: {hand: {fmu: hnd}}\n", "include: nowhere.yaml\n", "components: {hand: ~}\n"),
)
DEVICE_CHANGES: dict[str, tuple[str, ...]] = {
    "driver: mock": ("", "driver: mok", "driver: haply", "driver: 7"),
    "preset: quanser": ("preset: qanser", "preset: [1]", "presets: quanser"),
    "proximal: 0.1,": (
        "proximal: -0.1,",
        "proximal: .nan,",
        "proximl: 0.1,",
        "proximal: 10 kg,",
        "proximal: x,",
    ),
    "direction: 1": ("direction: 2", "direction: left", "dirction: 1"),
    "counts_per_turn: 20000}]": (
        "counts_per_turn: 0}]",
        "counts_per_turn: 1.5}]",
        "counts_per_turn: .inf}]",
    ),
    "torque: 0.1": ("torque: 100", "torque: -1", "torqe: 0.1", "torque: .nan", "torque: 0.1 m"),
}


def _damaged(change: Callable[[dict[str, bytes]], object]) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with zipfile.ZipFile(fmus.find("hand")) as good:
            files = {entry: good.read(entry) for entry in good.namelist()}
        change(files)
        with zipfile.ZipFile(path, "w") as bad:
            for entry, data in files.items():
                bad.writestr(entry, data)

    return write


def _xml(old: bytes, new: bytes) -> Callable[[Path], None]:
    name = "modelDescription.xml"
    return _damaged(lambda files: files.update({name: files[name].replace(old, new)}))


def _without(part: str) -> Callable[[Path], None]:
    return _damaged(lambda files: [files.pop(name) for name in list(files) if part in name])


def _garbage_library(files: dict[str, bytes]) -> None:
    for name in files:
        if name.startswith("binaries/"):
            files[name] = b"no library"


FMUS: Files = {
    "text": "this is no archive\n",
    "empty": "",
    "half": lambda path: path.write_bytes(fmus.find("hand").read_bytes()[:4000]),
    "folder": lambda path: path.mkdir(),
    "no description": _without("modelDescription"),
    "no library": _without("binaries/"),
    "garbage library": _damaged(_garbage_library),
    "cut xml": _damaged(
        lambda files: files.update({"modelDescription.xml": files["modelDescription.xml"][:400]})
    ),
    "no co-simulation": _xml(b"CoSimulation", b"ModelExchange"),
    "version": _xml(b'fmiVersion="', b'fmiVersion="9'),
    "outside": _damaged(lambda files: files.update({"../evil": b"x"})),
}


def _with(method: str) -> str:
    return COMPONENT.replace("    @property", f"    {method}\n\n    @property", 1)


PYTHON = {
    "syntax": "def broken(:\n",
    "raises": "raise ValueError('no')\n",
    "no class": "class Other: ...\n",
    "no component": "class Guest: ...\n",
    "init": COMPONENT.replace(
        "    @property",
        "    def __init__(self):\n        raise ValueError('no')\n\n    @property",
        1,
    ),
    "arguments": COMPONENT.replace(
        "    @property", "    def __init__(self, needed): ...\n\n    @property", 1
    ),
    "variables": COMPONENT.replace("return (Variable", "return 7  # (Variable"),
    "twice": COMPONENT.replace("return (", "return 2 * ("),
}


def cases() -> list[Case]:
    """All of them."""
    found: list[Case] = []
    for old, many in CHANGES.items():
        assert BASE.count(old) == 1, old
        found += [Case(f"{old} | {new}", BASE.replace(old, new), BASE) for new in many]
    found += [Case(f"--set {text}", BASE, BASE, sets=(text,)) for text in SETS]
    found += [Case(f"--with {text}", BASE, BASE, overlay=text) for text in OVERLAYS]
    for old, many in DEVICE_CHANGES.items():
        assert DEVICE.count(old) == 1, old
        for new in many:
            files: Files = {"device.yaml": DEVICE.replace(old, new)}
            right: Files = {"device.yaml": DEVICE}
            found.append(
                Case(f"device {old} | {new}", BENCH, BENCH, files=files, right_files=right)
            )
    good: Files = {"foreign.fmu": _damaged(lambda _: None)}
    found += [
        Case(f"fmu {name}", FOREIGN, FOREIGN, files={"foreign.fmu": how}, right_files=good)
        for name, how in FMUS.items()
    ]
    for number, (name, code) in enumerate(PYTHON.items()):
        # A module is read once in a process: each case has one of its own.
        wrong, right_name = f"guest_wrong_{number}", f"guest_right_{number}"
        found.append(
            Case(
                f"python {name}",
                GUEST.replace("MODULE", wrong),
                GUEST.replace("MODULE", right_name),
                files={f"{wrong}.py": code},
                right_files={f"{right_name}.py": COMPONENT},
            )
        )
    return found
