"""Co-simulation and hardware-in-the-loop for cooperative haptics over a network.

    import cohaptic

    scenario = cohaptic.load("two_users_box", sets=["duration=2 s"])
    finished = cohaptic.run(scenario)
    with cohaptic.open_run(finished.folder) as record:
        print(record.signals["vr_a.box_pose.y"].values)

A name is imported when it is first used, so that ``import cohaptic`` itself costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cosim.base.component import Causality, Component, Variable, VariableType
    from cosim.reading import edit, load
    from cosim.record import open_run
    from cosim.run import run_scenario as run
    from cosim.scenario import Scenario
    from cosim.sweep.ask import sweep
    from cosim.sweep.theory import spectral_radius
else:
    _HOMES = {
        "Causality": ("cosim.base.component", "Causality"),
        "Component": ("cosim.base.component", "Component"),
        "Variable": ("cosim.base.component", "Variable"),
        "Scenario": ("cosim.scenario", "Scenario"),
        "VariableType": ("cosim.base.component", "VariableType"),
        "edit": ("cosim.reading", "edit"),
        "load": ("cosim.reading", "load"),
        "open_run": ("cosim.record", "open_run"),
        "run": ("cosim.run", "run_scenario"),
        "spectral_radius": ("cosim.sweep.theory", "spectral_radius"),
        "sweep": ("cosim.sweep.ask", "sweep"),
    }

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name not in _HOMES:
            raise AttributeError(f"module 'cohaptic' has no attribute '{name}'")
        module, attribute = _HOMES[name]
        found = getattr(import_module(module), attribute)
        globals()[name] = found
        return found

    def __dir__() -> list[str]:
        return sorted({*globals(), *_HOMES})


__all__ = [
    "Causality",
    "Component",
    "Scenario",
    "Variable",
    "VariableType",
    "edit",
    "load",
    "open_run",
    "run",
    "spectral_radius",
    "sweep",
]
