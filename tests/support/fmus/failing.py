"""Every call of the binding, every way to fail in it, wherever it runs; and what is right then."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import pytest

from cosim.base.errors import CohapticError
from cosim.cli.support.run.one import RunOptions, read_one, run_one
from cosim.master.fmu import fmi2, fmi3, state
from cosim.record.reader import open_run
from tests.support.fmus.mortal import RATE, TICKS, TYPES, mortal_fmu, scenario
from tests.support.scratch import scratch_folder

BOUND = {
    2: {**fmi2.PROTOTYPES, **state.FMI2.prototypes()},
    3: {**fmi3.PROTOTYPES, **state.FMI3.prototypes()},
}
"""Every function that is called by us, of each version."""
DEATHS = {
    "exit(0)": "ended the process (exit status 0)",
    "_exit(0)": "ended the process (exit status 0)",
    "exit(3)": "ended the process (exit status 3)",
    "abort": "crashed (SIGABRT: aborted)",
    "exception": "crashed (SIGABRT: aborted)",
    "SIGSEGV": "crashed (SIGSEGV: segmentation fault)",
    "SIGFPE": "crashed (SIGFPE: floating point exception)",
}
"""Ways in which the process ends; an exception is one of C++ that nobody catches."""
STATUSES = {"2": "discard", "3": "error", "4": "fatal", "99": "99", "100": "100"}
"""What a call may return that is not well, two numbers among it that the standard does not have."""
WAYS = (*DEATHS, *STATUSES)
PLACES = ("here", "isolated", "paced", "paced isolated")
NONE, PART, WHOLE = (
    "nothing was recorded",
    "what was written before is kept",
    "the record is complete",
)
_LATE = f"at tick 3 ({3 / RATE:g} s)"
_END = f"at tick {TICKS} ({TICKS / RATE:g} s)"


@dataclass(frozen=True, slots=True)
class Case:
    """One call of an FMU; ``after`` so many steps were begun."""

    version: int
    call: str
    """As the standard has it, without its prefix."""
    after: int
    when: str
    """Of a sentence about a death."""
    refused: str
    """The sentence about a status, from behind the component's name on."""
    record: str
    is_input: bool = False
    """Whether a status that is not fatal is taken for a mistake of what it was given."""
    is_bare: bool = False
    """Whether one input alone is connected, and event mode is used where there is one."""
    snapshots: str = ""
    """``save`` or ``load``."""
    label: str = ""
    """Where one call has several cases."""

    @property
    def function(self) -> str:
        """The function of the standard."""
        co_simulation = "CoSimulation" if self.call == "Instantiate" and self.version == 3 else ""
        return f"fmi{self.version}{self.call}{co_simulation}"

    @property
    def has_status(self) -> bool:
        """Whether the function can tell that it failed."""
        return self.call != "FreeInstance"

    def __str__(self) -> str:
        return self.function + (f" {self.label}" if self.label else "")


def _early(version: int, call: str, refused: str) -> Case:
    case = Case(version, call, 0, "", refused, NONE, is_input=True)
    return _noted(case, "before the first tick")


def _noted(case: Case, when: str) -> Case:
    return replace(case, when=f"in {case.function} {when}")


def _cases(version: int) -> Iterator[Case]:
    refuses = ": the FMU refused to {} (status {{word}})"
    yield _early(version, "Instantiate", f": the FMU mortal{version}.fmu could not be instantiated")
    yield _early(version, "SetDebugLogging", refuses.format("choose what is logged"))
    if version == 2:
        yield _early(2, "SetupExperiment", refuses.format("set up the experiment"))
    else:
        yield _early(3, "EnterConfigurationMode", refuses.format("enter configuration mode"))
        yield _early(3, "ExitConfigurationMode", refuses.format("leave configuration mode"))
    yield _early(version, "SetString", ": the FMU refuses p = 'text'")
    yield _early(version, "EnterInitializationMode", refuses.format("enter initialisation mode"))
    yield _early(version, "ExitInitializationMode", refuses.format("leave initialisation mode"))
    yield from _values(version)
    step = " returned status '{word}' from its step " + _LATE
    yield Case(version, "DoStep", 3, f"in its step {_LATE}", step, PART)
    if version == 2:
        discards = step.format(word="discard")
        yield _noted(Case(2, "GetBooleanStatus", 3, "", discards, PART), _LATE)
    else:
        yield from _events()
    yield from _states(version)
    ends = f" returned status '{{word}}' from fmi{version}Terminate {_END}"
    yield _noted(Case(version, "Terminate", 0, "", ends, WHOLE), _END)
    yield _noted(Case(version, "FreeInstance", 0, "", "", WHOLE), _END)


def _values(version: int) -> Iterator[Case]:
    real, whole = {2: ("Real", "Integer"), 3: ("Float64", "Int32")}[version]
    first, said = "at initialisation", " returned status '{{word}}' from {} {}"
    for verb, does, word in (
        ("Set", "while its inputs were set", "setting its inputs"),
        ("Get", "while its outputs were read", "reading its outputs"),
    ):
        refused = said.format(word, first)
        call = f"{verb}{real}"
        yield Case(version, call, 0, f"{does} {first}", refused, NONE, is_input=True, label="first")
        refused = said.format(word, _LATE)
        for kind in (real, *TYPES[version]):
            name = {"Int32": "Integer"}.get(kind, kind) if version == 2 else kind
            is_text = kind in {"String", "Binary"}
            case = Case(version, f"{verb}{name}", 3, f"{does} {_LATE}", refused, PART, label="late")
            yield _noted(case, _LATE) if is_text else case
    refused = said.format("the turning of a parameter", _LATE)
    when = f"while a parameter was turned {_LATE}"
    yield Case(version, f"Set{whole}", 3, when, refused, PART, is_bare=True, label="turned")


def _events() -> Iterator[Case]:
    first = "at initialisation"
    for call in ("GetIntervalDecimal", "GetShiftDecimal"):
        refused = f" returned status '{{word}}' in fmi3{call} {first}"
        case = Case(3, call, 0, "", refused, NONE, is_input=True, is_bare=True)
        yield _noted(case, first)
    refused = ": the FMU refused to take the intervals of its clocks (status {word})"
    case = Case(3, "SetIntervalDecimal", 0, "", refused, NONE, is_input=True, is_bare=True)
    yield _noted(case, "before the first tick")
    for call in ("EnterEventMode", "SetClock", "GetClock", "UpdateDiscreteStates", "EnterStepMode"):
        refused = f" returned status '{{word}}' in fmi3{call} {_LATE}"
        yield _noted(Case(3, call, 4, "", refused, PART, is_bare=True), _LATE)


def _states(version: int) -> Iterator[Case]:
    functions = {2: state.FMI2, 3: state.FMI3}[version]
    saves = f": the FMU cannot save its state {_LATE} (status {{word}})"
    loads = ": the FMU cannot restore its state at tick 0 (0 s) (status {word})"
    for name in (functions.get, functions.size, functions.serialise, functions.free):
        call = name.removeprefix(f"fmi{version}")
        yield _noted(Case(version, call, 0, "", saves, PART, snapshots="save"), _LATE)
    for name in (functions.deserialise, functions.set):
        call = name.removeprefix(f"fmi{version}")
        case = Case(version, call, 0, "", loads, NONE, snapshots="load")
        yield _noted(case, "before the first tick")


CASES = [case for version in (2, 3) for case in _cases(version)]


def is_possible(case: Case, way: str, place: str) -> bool:
    """Whether a function can fail so there: snapshots are for runs that keep no pace."""
    return (case.has_status or way in DEATHS) and not (case.snapshots and "paced" in place)


@dataclass(frozen=True, slots=True)
class Ended:
    """What became of a run."""

    status: int
    message: str
    folder: Path
    called_after: list[str]
    """What was called after a status that is not well, in order."""


def ended(folder: Path, case: Case, way: str, place: str) -> Ended:
    """Run the scenario until ``box`` fails."""
    options = RunOptions(
        figure=False,
        realtime="paced" in place,
        snapshots=("0.03 s",) if case.snapshots == "save" else (),
        origin=_earlier(case.version, "isolated" in place) if case.snapshots == "load" else None,
    )
    file = folder / "test.yaml"
    file.write_text(scenario(case.version, is_bare=case.is_bare, is_isolated="isolated" in place))
    with failing(case.call, case.after, way, folder / "called"):
        status, message = _run(None if options.origin else file, folder / "out", options)
    called = folder / "called"
    after = called.read_text().split() if called.exists() else []
    return Ended(status, message, folder / "out", after)


def _run(file: Path | None, out: Path, options: RunOptions) -> tuple[int, str]:
    try:
        chosen = read_one(None if file is None else str(file), options, print)
        finished = run_one(chosen, out, options, print)
    except CohapticError as error:
        return error.exit_status, str(error)
    error = finished.error
    return int(finished.summary.content["status"]), str(error) if error is not None else ""


@contextmanager
def failing(call: str, after: int, way: str, called: Path) -> Iterator[None]:
    """Processes that begin inside find ``call`` failing."""
    with pytest.MonkeyPatch.context() as given:
        given.setenv("FAILS_IN", call)
        given.setenv("FAILS_AFTER", str(after))
        given.setenv("FAILS_BY", way)
        given.setenv("CALLED_AFTER", str(called))
        yield


@cache
def _earlier(version: int, is_isolated: bool) -> str:
    """A run that has left a snapshot, in the form of ``--from``."""
    folder = scratch_folder("test")
    file, out = folder / "test.yaml", folder / "out"
    file.write_text(scenario(version, is_bare=False, is_isolated=is_isolated))
    with failing("nothing", 0, "", Path(os.devnull)):
        done = _run(file, out, RunOptions(figure=False, snapshots=("0.03 s",)))
    assert done == (0, ""), done
    return f"{out}@0.03s"


def check(done: Ended, case: Case, way: str, place: str) -> None:
    """Status, sentence, record, and what was called after."""
    if way in DEATHS:
        expected, sentence, record = 1, f"box {DEATHS[way]} {case.when}", case.record
        if "isolated" not in place or record == WHOLE:
            sentence += f"; {record}"
    elif case.call == "SetDebugLogging" and way != "4":
        expected, sentence, record = 0, "", WHOLE  # one that says less
    else:
        is_refused = case.is_input and (way != "4" or case.call == "Instantiate")
        expected, record = 2 if is_refused else 1, case.record
        sentence = "box" + case.refused.format(word=STATUSES[way])
        allowed = {"FreeInstance"}
        if way == "2" and case.snapshots:
            allowed.add("Terminate")
        if way == "2" and str(case) == "fmi2DoStep":
            allowed.add("GetBooleanStatus")
        free = "FreeFMUState" if case.version == 3 else "FreeFMUstate"
        after = set() if way == "4" else allowed | {free}
        assert set(done.called_after) <= after
        assert way == "4" or case.call == "Instantiate" or "FreeInstance" in done.called_after
    assert done.status == expected, done.message
    assert sentence in done.message
    if record == NONE:
        assert not done.folder.exists()
        return
    summary = json.loads((done.folder / "summary.json").read_text())
    manifest = json.loads((done.folder / "manifest.json").read_text())
    assert summary["status"] == manifest["exit"]["status"] == expected
    assert summary["message"] == manifest["exit"]["message"]
    assert sentence in summary["message"]
    with open_run(done.folder) as run:
        assert run.ticks == TICKS if record == WHOLE else run.ticks <= 4
        assert all(group.capacity == group.rows for group in run.groups.values())


def archives() -> None:
    """Compile both FMUs, which takes a second."""
    for version in (2, 3):
        mortal_fmu(version)
