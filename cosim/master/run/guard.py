"""A Python component's outputs are looked at when it has put them out, like those of an FMU.

Otherwise a NaN would be noticed where it arrives, and its reader blamed. What a device cannot
measure it puts out as NaN on purpose; nothing may be connected to that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cosim.base.component import Causality, Component, Role
from cosim.base.errors import RunError
from cosim.master.components.interface import Element, has_cells, size_of
from cosim.master.kernel.native import library
from cosim.master.kernel.program import Call, Program
from cosim.master.run.diagnosis import moment


def guarded(
    program: Program, components: Mapping[str, Component], call: Call
) -> Callable[[int], None]:
    """What a call-out does: a channel that is turned, or the method of a component.

    Raises, when called:
        RunError: an output of the component became NaN.
    """
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
