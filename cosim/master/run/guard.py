"""A Python component's outputs are looked at when it has put them out, like those of an FMU.

Otherwise a NaN would be noticed where it arrives, and its reader blamed. What a device cannot
measure it puts out as NaN on purpose; nothing may be connected to that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from cosim.base.component import Causality, Component, Role
from cosim.base.errors import RunError
from cosim.master.components.interface import Element, has_cells, size_of
from cosim.master.fmu.binding import OK, WARNING
from cosim.master.kernel.native import library
from cosim.master.kernel.program import Program
from cosim.master.kernel.written import Call
from cosim.master.run.diagnosis import moment


class StatusReturnedError(RunError):
    """An FMU returned what is not well when its texts were passed; the kernel's status has it."""

    def __init__(self) -> None:
        super().__init__("an FMU returned a status")


def guarded(
    program: Program, components: Mapping[str, Component], call: Call
) -> Callable[[int], None]:
    """What a call-out does: turn a channel, call a component's method, pass or record texts.

    Raises, when called:
        RunError: an output of the component became NaN, or a text is too long.
        StatusReturnedError: an FMU's status is that of an error.
    """
    if call.passes is not None:
        return partial(_pass_texts, program, call, call.passes)
    if call.records is not None:
        return call.records
    if call.is_channel:
        return lambda _: program.channels.carry_out((call.component, call.method))
    component = components[call.component]
    handler: Callable[[int], None] = getattr(component, call.method)
    interface = program.parts[call.component].interface
    numbers = [
        program.layout.cells[call.component, variable.name] + index
        for variable in interface.variables.values()
        if variable.causality is Causality.OUTPUT and variable.type.is_float
        if has_cells(variable) and variable.role is not Role.SIMULATION_ONLY
        for index in range(size_of(variable))
    ]
    if not numbers or call.method == "write":
        return handler
    outputs, cells = np.array(numbers, dtype=np.int64), program.cells
    where = int(cells.ctypes.data), int(outputs.ctypes.data), len(numbers)
    first_nan = library().kernel_first_nan

    def handle(tick: int) -> None:
        handler(tick)
        bad = first_nan(*where)
        if bad >= 0:
            # The array is named here to live as long as its address is used.
            _, variable, index = program.layout.owner(int(outputs[bad]))
            name = interface.element_name(Element(variable, index))
            raise RunError(
                f"{call.component}.{name} became NaN in {call.method} at {moment(program)}"
            )

    return handle


def _pass_texts(program: Program, call: Call, passes: Callable[[], int], tick: int) -> None:
    del tick
    try:
        status = passes()
    except ValueError as error:
        raise RunError(f"{call.component}: {error}, at {moment(program)}") from None
    if status == WARNING:
        program.warn(call.component)
    elif status != OK:
        program.kernel.status = status
        raise StatusReturnedError
