"""Co-simulation and hardware-in-the-loop for cooperative haptics over a network.

    import cohaptic

    finished = cohaptic.run("two_users_box", sets=["duration=2 s"])
    with finished.open() as record:
        print(record["vr_a.box_pose.y"].values)

A name is imported when it is first used, so that ``import cohaptic`` itself costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cohaptic import fmu, theory
    from cohaptic.identified import identify
    from cohaptic.runs import resume, run
    from cohaptic.theory import spectral_radius
    from cosim.base.component import Causality, Component, Variable, VariableType
    from cosim.reading import edit, load
    from cosim.record import open_run
    from cosim.scenario import Scenario
    from cosim.sweep.ask import sweep
else:
    _HOMES = {
        "Causality": ("cosim.base.component", "Causality"),
        "Component": ("cosim.base.component", "Component"),
        "Variable": ("cosim.base.component", "Variable"),
        "Scenario": ("cosim.scenario", "Scenario"),
        "VariableType": ("cosim.base.component", "VariableType"),
        "edit": ("cosim.reading", "edit"),
        "identify": ("cohaptic.identified", "identify"),
        "load": ("cosim.reading", "load"),
        "open_run": ("cosim.record", "open_run"),
        "resume": ("cohaptic.runs", "resume"),
        "run": ("cohaptic.runs", "run"),
        "spectral_radius": ("cohaptic.theory", "spectral_radius"),
        "sweep": ("cosim.sweep.ask", "sweep"),
    }

    _MODULES = ("fmu", "theory")

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name not in {*_HOMES, *_MODULES}:
            raise AttributeError(f"module 'cohaptic' has no attribute '{name}'")
        if name in _MODULES:
            return import_module(f"cohaptic.{name}")
        module, attribute = _HOMES[name]
        found = getattr(import_module(module), attribute)
        globals()[name] = found
        return found

    def __dir__() -> list[str]:
        return sorted({*globals(), *_HOMES, *_MODULES})


__all__ = [
    "Causality",
    "Component",
    "Scenario",
    "Variable",
    "VariableType",
    "edit",
    "fmu",
    "identify",
    "load",
    "open_run",
    "resume",
    "run",
    "spectral_radius",
    "sweep",
    "theory",
]
