"""What a snapshot belongs to: the plan of its run, and each of its components."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.files import files_read
from cosim.master.assembly.plan import Action
from cosim.master.assembly.wiring import Bundle
from cosim.master.components.participant import Participant
from cosim.scenario import Kind


def plan_digest(assembly: Assembly) -> str:
    """SHA-256 (hex) of rates, order, wiring, cells and channels; the run's length is left out."""
    state = hashlib.sha256()
    for part in _plan(assembly):
        state.update(repr(part).encode() + b"\n")
    return state.hexdigest()


def components_of(assembly: Assembly) -> dict[str, dict[str, str | None]]:
    """What each component is, by name: its kind, its FMU or class, digests of files and values."""
    return {
        name: {
            "kind": str(assembly.scenario.components[name].kind),
            "fmu": None if each.fmu is None else each.fmu.sha256,
            "class": None if each.component is None else _class_of(each.component),
            "files": _files_digest(each, assembly.scenario.components[name].kind),
            "values": _values_digest(each, assembly.scenario.components[name].parameters),
        }
        for name, each in assembly.participants.items()
    }


def difference(
    saved: Mapping[str, Mapping[str, str | None]], now: Mapping[str, Mapping[str, str | None]]
) -> str | None:
    """A sentence on the first component that is another one now, or ``None``."""
    if set(saved) != set(now):
        return (
            f"it was taken of a run with the components {', '.join(sorted(saved))}; this one has "
            f"{', '.join(sorted(now))}."
        )
    for name, there in saved.items():
        here = now[name]
        if there.get("fmu") != here["fmu"]:
            return (
                f"its FMU of {name} has another content (SHA-256 {str(there.get('fmu'))[:12]}…, "
                f"now {str(here['fmu'])[:12]}…); use the FMU with which it was taken, or take "
                "it again."
            )
        if (there.get("kind"), there.get("class")) != (here["kind"], here["class"]):
            return f"{name} was {there.get('class') or there.get('kind')} when it was taken."
        if there.get("files") != here["files"]:
            return (
                f"a file that {name} reads had another content when it was taken; put that back, "
                "or take a new one."
            )
        if there.get("values") != here["values"]:
            return (
                f"{name} had other parameters, start values or rows when it was taken; run it with "
                "those, or take a new one."
            )
    return None


def _plan(assembly: Assembly) -> Iterator[Any]:
    yield assembly.scenario.base_rate, assembly.scenario.start_tick
    for actions in (assembly.plan.initial, assembly.plan.first, assembly.plan.every):
        yield [_action(action) for action in actions]
    layout = assembly.layout
    yield (
        list(layout.cells.items()),
        list(layout.wanted.items()),
        layout.held,
        layout.age,
        layout.sequence,
        layout.count,
    )
    yield assembly.wiring.wires
    for name, each in assembly.participants.items():
        yield name, each.period, each.substeps
    for bundle in assembly.wiring.bundles:
        yield _bundle(bundle)


def _action(action: Action) -> tuple[Any, ...]:
    return action.act.name, action.unit, action.period, action.names


def _bundle(bundle: Bundle) -> tuple[Any, ...]:
    fates = bundle.fates
    effects = [(name, _effect(e)) for name, e in sorted(fates.direction.impairments.items())]
    delay = fates.direction.delay.ticks
    room = fates.shortest, fates.longest
    return bundle.name, bundle.way, bundle.period, bundle.entries, fates.key, delay, effects, room


def _effect(effect: Any) -> Any:
    """What makes an effect equal to another: not where its file lies."""
    if not is_dataclass(effect):
        return effect.describe()
    return [(each.name, getattr(effect, each.name)) for each in fields(effect) if each.compare]


def _class_of(component: object) -> str:
    return f"{type(component).__module__}:{type(component).__qualname__}"


def _files_digest(participant: Participant, kind: Kind) -> str | None:
    """Of all that it reads: tables of its parameters, an earlier run, the module of its class."""
    files = files_read(participant)
    if participant.component is not None:
        files += participant.component.files
        if kind is Kind.PYTHON:
            files += _module_of(participant.component)
    if not files:
        return None
    return hashlib.sha256("\n".join(map(_content, files)).encode()).hexdigest()


def _module_of(component: object) -> list[Path]:
    """Where its class is written; nowhere, where somebody wrote it in a notebook."""
    module = sys.modules.get(type(component).__module__)
    file = getattr(module, "__file__", None)
    return [] if file is None else [Path(file)]


def _content(file: Path) -> str:
    """A digest, taken again where time or size is another."""
    try:
        stat = file.stat()
        return _digest_of(file, (stat.st_ino, stat.st_size, stat.st_mtime_ns))
    except OSError as error:
        return f"{error.strerror}"


@lru_cache(maxsize=256)
def _digest_of(file: Path, _mark: tuple[int, ...]) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()


def _values_digest(participant: Participant, written: Mapping[str, Any]) -> str:
    given = repr((participant.parameters, participant.start))
    own = "" if participant.component is None else repr(sorted(written.items()))
    state = hashlib.sha256(f"{given}\n{own}".encode())
    if (played := participant.played) is not None:
        state.update(played.times.tobytes() + played.rows.tobytes() + bytes([played.is_linear]))
    return state.hexdigest()
