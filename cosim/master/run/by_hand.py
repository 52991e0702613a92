"""Knobs that are turned while a run goes on, by whoever holds it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosim.base.errors import InputError
from cosim.master.assembly.assemble import Assembly
from cosim.master.kernel.program import Program


def turn(assembly: Assembly, program: Program, values: Mapping[str, Any]) -> None:
    """Turn knobs from the next tick on; all of them, or none. From any thread.

    Raises:
        InputError: there is no such knob, a connection drives it, or it does not go so far.
    """
    knobs = assembly.knobs
    found = [entry for key, value in values.items() for entry in knobs.judge(key, value).items()]
    for name, _ in found:
        if driver := knobs.all[name].connection:
            raise InputError(f"{'.'.join(name)} is driven by {driver}")
    program.turning.asked.extend((name, tuple(elements)) for name, elements in found)
