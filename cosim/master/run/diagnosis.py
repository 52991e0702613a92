"""Why the kernel stopped, in a sentence: the component, the tick, the time, what the FMU logged."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cosim.base.component import Variable, VariableType
from cosim.base.errors import CohapticError, EndAsked, InputError, RunError
from cosim.master.assembly.plan import Act
from cosim.master.components.interface import Element
from cosim.master.fmu.instance import Fmu
from cosim.master.fmu.loaded.conduct import status_word
from cosim.master.kernel.codes import EventCall, EventFault, KernelOutcome, OperationKind
from cosim.master.kernel.program import Program
from cosim.master.run.whereabouts import AT_EVENTS

_DID = {
    Act.SET: "setting its inputs",
    Act.GET: "reading its outputs",
    Act.STEP: "its step",
    Act.TUNE: "the turning of a parameter",
}

_HINTS = {
    "discard": "; it could not take a step of this length: a higher rate makes shorter ones",
    "pending": "; it steps asynchronously, which nobody waits for here",
}
"""What to do about a status of a step."""
_IN = {
    Act.SET: "while its inputs were set",
    Act.GET: "while its outputs were read",
    Act.STEP: "in its step",
    Act.TUNE: "while a parameter was turned",
}


def explain(outcome: KernelOutcome, program: Program, fmus: dict[str, Fmu]) -> CohapticError:
    """The error that the kernel's outcome stands for.

    What an FMU refuses at initialisation is what the scenario gave it: an input error.
    """
    kernel = program.kernel
    action = program.stopped_at()
    component = str(action.unit)
    when = moment(program)
    fmu = fmus.get(component)
    chatted = fmu.reason() if fmu is not None else ""
    logged = chatted or "; it logged nothing"
    act = Act.TUNE if kernel.kind == OperationKind.TUNE else action.act
    at_event = AT_EVENTS.get(EventCall(kernel.event_call)) if action.act is Act.STEP else None
    if outcome is KernelOutcome.STATUS:
        number = int(kernel.status)
        if fmu is not None and fmu.is_gone:
            place = at_event or _IN[act]
            return RunError(f"{component} {fmu.manner_of_ending()} {place} at {when}{chatted}")
        status = status_word(number)
        is_step = act is Act.STEP and at_event is None
        if status == "discard" and is_step and fmu is not None and fmu.asks_to_end():
            return EndAsked(f"{component} asked to end the simulation at {when}{chatted}")
        kind = RunError if kernel.running or status == "fatal" else InputError
        came = at_event or f"from {_DID[act]}"
        hint = _HINTS.get(status, "") if is_step else ""
        return kind(f"{component} returned status '{status}' {came} at {when}{logged}{hint}")
    if outcome is KernelOutcome.NOT_A_NUMBER:
        return RunError(f"{_variable(program)} became NaN at {when}{logged}")
    if outcome is KernelOutcome.RANGE:
        return RunError(_out_of_range(program, when))
    if outcome is KernelOutcome.EARLY_RETURN:
        return RunError(
            f"{component} returned early from its step at {when}, though that was not allowed; it "
            "is where event mode is used (event_mode: true) and steps may have any length"
        )
    if outcome is KernelOutcome.EVENT:
        kind = RunError if kernel.running else InputError
        return kind(f"{component}{_event_fault(program, component)} at {when}{chatted}")
    if outcome is KernelOutcome.TERMINATED and not kernel.running:
        return InputError(f"{component} asked to end the simulation before its first tick{chatted}")
    if outcome is KernelOutcome.TERMINATED:
        return EndAsked(f"{component} asked to end the simulation at {when}{chatted}")
    return RunError(f"the plan's room for packets or rows was exceeded at {when}; report this")


def _event_fault(program: Program, component: str) -> str:
    """What an FMU in event mode cannot be followed in."""
    kernel = program.kernel
    fault, value = EventFault(kernel.event_fault), float(kernel.event_value)
    facts = program.parts[component].interface.events
    assert facts is not None
    number = int(kernel.event_clock)
    clock = f".{facts.clocks[number].name}" if number >= 0 else ""
    native = program.instances[program.numbers[component]]
    return {
        EventFault.NONE: "",
        EventFault.NO_END: f" wants its discrete states updated, {value:g} times over,",
        EventFault.OFF_GRID: (
            f"{clock} is to tick after {value:g} s, which is no whole number of the component's "
            f"steps of {native.step:g} s,"
        ),
        EventFault.NO_INTERVAL: f"{clock} has to tell its next interval, and tells none,",
        EventFault.RETURNS: f" returned from one step {value:g} times over",
        EventFault.TIME: f" returned early at {value:g} s, which is outside of its step,",
        EventFault.NO_TIME: f" announced its next event for {value:g} s, which is no time,",
    }[fault]


def moment(program: Program) -> str:
    """The tick and the time that the kernel is at."""
    if program.kernel.running == 0:
        return "initialisation"
    tick = program.kernel.tick
    return f"tick {tick} ({program.clock.seconds(tick):g} s)"


def _out_of_range(program: Program, when: str) -> str:
    if program.kernel.kind == OperationKind.CONVERT:
        number = int(program.cells[program.kernel.cell])
        return (
            f"{_variable(program)} cannot be {number} at {when}: a real number is as exact as "
            f"that up to {2**53}"
        )
    kind = _type(program)
    cell = program.cells[program.kernel.cell : program.kernel.cell + 1]
    at_event = program.kernel.event_call == EventCall.GET
    if program.stopped_at().act is Act.GET or at_event:
        value = int(cell[0]) % 2**64
        return (
            f"{_variable(program)} became {value} at {when}: whole numbers are carried up to "
            f"{2**63 - 1}"
        )
    value = cell.view(np.float64)[0] if kind.is_float else cell[0]
    if program.kernel.kind == OperationKind.TUNE:
        return _beyond_a_knob(program, float(value), when)
    if items := _described(program).items:
        return f"{_variable(program)} cannot take {value} at {when}: it is one of {_words(items)}"
    return f"{_variable(program)} cannot take {value} at {when}: it is of type {kind}"


def _beyond_a_knob(program: Program, value: float, when: str) -> str:
    component, variable, _ = program.layout.owner(program.kernel.cell)
    knob = program.turning.knobs[component, variable]
    unit = f" {knob.variable.unit}" if knob.variable.unit not in {None, "", "1"} else ""
    driver = f" by {knob.connection}" if knob.connection else ""
    goes = f"goes from {knob.minimum:g}{unit} to {knob.maximum:g}{unit}"
    if items := knob.variable.items:
        goes = f"is one of {_words(items)}"
    return f"{component}.{variable} was turned to {value:g}{unit}{driver} at {when}: it {goes}"


def _words(items: Mapping[str, int]) -> str:
    return ", ".join(f"{word} ({number})" for word, number in items.items())


def _variable(program: Program) -> str:
    component, variable, index = program.layout.owner(program.kernel.cell)
    interface = program.parts[component].interface
    return f"{component}.{interface.element_name(Element(variable, index))}"


def _type(program: Program) -> VariableType:
    return _described(program).type


def _described(program: Program) -> Variable:
    component, variable, _ = program.layout.owner(program.kernel.cell)
    if (component, variable) in program.turning.knobs:
        return program.turning.knobs[component, variable].variable
    return program.parts[component].interface.variables[variable]
