"""What a run draws: its boxes, fingers, devices, walls and channels, found by what signals mean.

Nothing here looks at a variable's name: a model declares meanings (docs/fmus.md), and what belongs
to one thing stands in one group of its component or has one number.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, cast

from cosim.base.component import Causality, Variable
from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import RecordGroup
from cosim.master.assembly.assemble import Assembly
from cosim.master.components.interface import size_of
from cosim.master.components.participant import Participant

POSE = (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE)
POSITION = (Meaning.FINGER_X, Meaning.FINGER_Y)
FORCE = (Meaning.FINGER_FORCE_X, Meaning.FINGER_FORCE_Y)
ANGLES = (Meaning.JOINT_ANGLE_1, Meaning.JOINT_ANGLE_2)
BASE = (Meaning.BASE_X, Meaning.BASE_Y, Meaning.BASE_ANGLE)
LENGTHS = (Meaning.PROXIMAL_LENGTH, Meaning.BASE_DISTANCE)
WALL = (
    Meaning.WALL_POINT_X,
    Meaning.WALL_POINT_Y,
    Meaning.WALL_NORMAL_X,
    Meaning.WALL_NORMAL_Y,
)
DEFAULT_SIDE = 0.1
"""Side (m) of a box whose model does not say."""
PRESET = -1.0
"""A length that is left to the device's preset."""

Signals = dict[tuple[Meaning, Slot], list[str]]


def describe_scene(assembly: Assembly, groups: Iterable[RecordGroup]) -> dict[str, Any]:
    """What can be drawn of a run, as JSON: signals by their recorded names, lengths in m.

    Only what is recorded is drawn: a thing whose position is not has no entry.
    """
    known: set[str] = set()
    meant: dict[str, Signals] = {}
    for column in (column for group in groups for column in group.columns):
        known.add(column.name)
        if column.meaning is not None:
            signals = meant.setdefault(column.name.partition(".")[0], {})
            signals.setdefault((column.meaning, column.belongs_to), []).append(column.name)
    boxes: list[dict[str, Any]] = []
    fingers: list[dict[str, Any]] = []
    bodies: list[dict[str, Any]] = []
    pointers: list[dict[str, Any]] = []
    walls: list[list[float]] = []
    shares = _shares(assembly, meant)
    links = assembly.scenario.connections
    for name, participant in assembly.participants.items():
        signals = meant.get(name, {})
        station = assembly.scenario.components[name].station
        if pose := _all(signals, POSE):
            boxes.append({"name": name, "station": station, "pose": pose, **_box(signals)})
            boxes[-1] |= {**_numbers(participant), **shares.get(name, {})}
            walls += [wall for wall in _walls(participant) if wall not in walls]
        of_world = shares.get(name, {})
        driven = [link.target.path for link in links if link.target.component == name]
        fingers += [
            finger | of_world
            for finger in _fingers(name, station, participant, signals)
            if _is_there(participant, driven, Slot(finger=finger["finger"]))
        ]
        bodies += [
            {"name": name, "position": position}
            for position in signals.get((Meaning.AXIS_POSITION, Slot()), [])
        ]
        if valid := _one(signals, Meaning.POINTER_VALID):
            pointers.append(_pointer(name, station, valid, participant, signals))
    channels = [
        {"name": f"{channel}.{way}", "age": age, "sequence": sequence, "period": described.period}
        for channel, described in assembly.scenario.channels.items()
        for way in ("forward", "backward")
        if {age := f"{channel}.{way}.age", sequence := f"{channel}.{way}.sequence"} <= known
    ]
    return {
        "boxes": boxes,
        "fingers": fingers,
        "bodies": bodies,
        "pointers": pointers,
        "walls": walls,
        "channels": channels,
    }


def _shares(assembly: Assembly, meant: Mapping[str, Signals]) -> dict[str, dict[str, Any]]:
    """By component of one of two worlds: the crossfade's share, and which of its worlds it is."""
    sides = {Meaning.FADED_FIRST: 0, Meaning.FADED_SECOND: 1}
    found: dict[str, dict[str, Any]] = {}
    for link in assembly.scenario.connections:
        target = assembly.participants.get(link.target.component)
        variable = target and target.interface.variables.get(link.target.path)
        side = None if variable is None else sides.get(cast("Meaning", variable.meaning_of()))
        share = _one(meant.get(link.target.component, {}), Meaning.FADED_SHARE)
        if side is not None and share is not None:
            found[link.source.component] = {"share": share, "world": side}
    return found


def _all(signals: Signals, wanted: Iterable[Meaning], slot: Slot | None = None) -> list[str]:
    """One signal for each meaning, or nothing where one is missing."""
    found = [signals.get((meaning, slot or Slot())) for meaning in wanted]
    return [each[0] for each in found if each] if all(found) else []


def _one(signals: Signals, meaning: Meaning, slot: Slot | None = None) -> str | None:
    return next(iter(signals.get((meaning, slot or Slot()), ())), None)


def _box(signals: Signals) -> dict[str, Any]:
    return {
        "nodes": signals.get((Meaning.NODE_POSITION, Slot()), []),
        "penetration": _one(signals, Meaning.WALL_PENETRATION),
    }


def _fingers(
    name: str, station: str, participant: Participant, signals: Signals
) -> Iterator[dict[str, Any]]:
    slots = [slot for meaning, slot in signals if meaning is Meaning.FINGER_X]
    for slot in slots:
        if position := _all(signals, POSITION, slot):
            yield {
                "name": f"{name} {slot.finger or 1}",
                "finger": slot.finger or 1,
                "component": name,
                "station": station,
                "position": position,
                "force": _all(signals, FORCE, slot),
                "state": _one(signals, Meaning.CONTACT_STATE, slot),
                "normal_force": _one(signals, Meaning.NORMAL_FORCE, slot),
                "energy": _one(signals, Meaning.PORT_ENERGY, slot),
                "limit": _values(participant, (Meaning.FORCE_LIMIT,), slot).get(
                    Meaning.FORCE_LIMIT
                ),
                "device": _device(participant, signals, slot),
            }


def _is_there(participant: Participant, driven: Iterable[str], slot: Slot) -> bool:
    """Whether something drives a finger; a world has room for more than a user may have."""
    angles = [
        variable.name
        for variable in participant.interface.variables.values()
        if variable.causality is Causality.INPUT
        and variable.meaning_of() in ANGLES
        and variable.slot_of() == slot
    ]
    reached = (path for path in driven for name in angles if f"{name}.".startswith(f"{path}."))
    return not angles or any(reached)


def _pointer(
    name: str, station: str, valid: str, participant: Participant, signals: Signals
) -> dict[str, Any]:
    """Where a person wants the fingers, and how far each may be led: x, y and radius (m)."""
    slots = [slot for meaning, slot in signals if meaning is Meaning.POINTER_X]
    centres: dict[int, list[float]] = {}
    for variable in _parameters(participant):
        for index in range(size_of(variable)):
            if variable.meaning_of(index) in {Meaning.REACH_X, Meaning.REACH_Y}:
                finger = variable.slot_of(index).finger or 1
                centres.setdefault(finger, []).append(_value(participant, variable, index))
    reach = _values(participant, (Meaning.REACH,)).get(Meaning.REACH, 0.0)
    return {
        "name": name,
        "station": station,
        "valid": valid,
        "count": _one(signals, Meaning.POINTER_COUNT),
        "fingers": [
            {
                "finger": slot.finger,
                "position": _all(signals, (Meaning.POINTER_X, Meaning.POINTER_Y), slot),
                "reach": [*centres.get(slot.finger or 1, [0.0, 0.0]), reach],
            }
            for slot in slots
        ],
    }


def _device(participant: Participant, signals: Signals, slot: Slot) -> dict[str, Any] | None:
    """The linkage that carries a finger: joint angles, its place and lengths."""
    angles = _all(signals, ANGLES, slot)
    values = _values(participant, (*BASE, *LENGTHS, Meaning.DEVICE_PRESET), slot)
    if not angles or not {*BASE, *LENGTHS} <= values.keys():
        return None
    proximal, distance = (
        _preset(meaning, values) if values[meaning] == PRESET else values[meaning]
        for meaning in LENGTHS
    )
    return {
        "angles": angles,
        "base": [values[meaning] for meaning in BASE],
        "proximal": proximal,
        "distance": distance,
    }


def _preset(meaning: Meaning, values: Mapping[Meaning, float]) -> float:
    from fmus.shared.mechanism.device import presets

    known = presets("GEOMETRY")[meaning.value]
    number = int(values.get(Meaning.DEVICE_PRESET, 0))
    return known[number] if number < len(known) else 0.0


def _numbers(participant: Participant) -> dict[str, float | None]:
    values = _values(participant, (Meaning.BOX_SIDE, Meaning.STATIC_FRICTION))
    return {
        "side": values.get(Meaning.BOX_SIDE, DEFAULT_SIDE),
        "friction": values.get(Meaning.STATIC_FRICTION),
    }


def _walls(participant: Participant) -> Iterator[list[float]]:
    """Point and normal of each wall that there is: x, y, x, y."""
    groups: dict[str, dict[Meaning, float]] = {}
    for variable in _parameters(participant):
        meaning = variable.meaning_of()
        if meaning is not None and meaning in {*WALL, Meaning.WALL_ENABLED}:
            group = variable.name.rpartition(".")[0]
            groups.setdefault(group, {})[meaning] = _value(participant, variable)
    for wall in groups.values():
        if wall.get(Meaning.WALL_ENABLED) and {*WALL} <= wall.keys():
            yield [wall[meaning] for meaning in WALL]


def _values(
    participant: Participant, wanted: Iterable[Meaning], slot: Slot | None = None
) -> dict[Meaning, float]:
    chosen = {*wanted}
    return {
        meaning: _value(participant, variable)
        for variable in _parameters(participant)
        if (meaning := variable.meaning_of()) is not None
        and meaning in chosen
        and (slot is None or variable.slot_of() == slot)
    }


def _parameters(participant: Participant) -> Iterator[Variable]:
    variables = participant.interface.variables.values()
    return (variable for variable in variables if variable.causality is Causality.PARAMETER)


def _value(participant: Participant, variable: Variable, index: int = 0) -> float:
    given = participant.parameters.get(variable.name)
    if given is not None:
        return float(given[index])
    start: Any = variable.start
    if isinstance(start, tuple | list):
        start = cast("list[Any]", start)[index]
    return float(start or 0.0)
