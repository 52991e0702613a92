"""Which parameters of a component may change while it runs."""

from __future__ import annotations

from cosim.base.component import Causality, Variable
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.master.components.interface import Interface, is_tunable


def named(interface: Interface, path: str) -> list[Variable]:
    """The variables that a path stands for: one, or the elements of an array without one."""
    if path in interface.variables:
        return [interface.variables[path]]
    base = path.rpartition("[")[0]
    if base in interface.variables and interface.variables[base].shape:
        return [interface.variables[base]]
    if not {f"{path}[1]", f"{path}[1,1]"} & interface.variables.keys():
        return []
    return [v for name, v in interface.variables.items() if name.startswith(f"{path}[")]


def tunable_at(interface: Interface, path: str) -> list[str]:
    """The tunable parameters that a path stands for.

    Raises:
        InputError: there is nothing of that name, or it stays as it is.
    """
    where = f"{interface.component}.{path}"
    known = sorted({v.name.split("[")[0] for v in interface.variables.values() if is_tunable(v)})
    found = named(interface, path)
    if not found:
        raise InputError(f"there is no parameter {where}.{did_you_mean(path, known)}")
    wrong = next((variable for variable in found if not is_tunable(variable)), None)
    if wrong is None:
        return [variable.name for variable in found]
    few = ", ".join(known[:8]) + (" …" if len(known) > 8 else "")
    others = f" Of {interface.component} can be turned: {few}." if known else ""
    match wrong.causality:
        case Causality.PARAMETER if wrong.type.is_text:
            why = f"is of type {wrong.type}; only numbers can be turned."
        case Causality.PARAMETER:
            why = f"is a {wrong.variability} parameter, set before the start and never again."
        case Causality.INPUT:
            why = "is an input, which a connection drives; a parameter can be turned."
        case _:
            why = f"is of causality '{wrong.causality}'; only a tunable parameter can be turned."
    raise InputError(f"{where} {why}{others}")
