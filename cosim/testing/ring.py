"""Rings and chains of light FMUs: a scenario of any size, every part of it alike."""

from __future__ import annotations

_WHERE = "station: bench, rate: 1024"
_COUPLER = "parameters: {stiffness: 300.0, damping: 2.0}"


def ring_scenario(components: int, *, ticks: int = 1024, record: str = "[]") -> str:
    """The YAML of a ring of ``components`` parts (an even number), half masses, half couplers.

    All of them run at 1024 Hz, for ``ticks`` ticks; ``record`` is the text of that section.
    """
    pairs = components // 2
    parts: list[str] = []
    wires: list[str] = []
    for number in range(pairs):
        place, after = 1.0 + 0.1 * (number % 7), (number + 1) % pairs
        values = f"parameters: {{mass: 0.5, initial_position: {place}}}"
        parts += [
            f"mass_{number}: {{fmu: hand, {_WHERE}, {values}}}",
            f"coupler_{number}: {{fmu: virtual_coupler, {_WHERE}, {_COUPLER}}}",
        ]
        wires += [
            f"mass_{number}.position -> coupler_{number}.position_a",
            f"mass_{number}.velocity -> coupler_{number}.velocity_a",
            f"mass_{after}.position -> coupler_{number}.position_b",
            f"mass_{after}.velocity -> coupler_{number}.velocity_b",
            f"coupler_{number}.reaction -> mass_{number}.force",
            f"coupler_{number}.force -> mass_{after}.coupler_force",
        ]
    return _scenario(f"{ticks}/1024", parts, wires, record)


def row_of_masses(
    masses: int, *, ticks: int, is_closed: bool = True, rate: int = 1024, every: int = 1
) -> str:
    """The YAML of a row of masses (FMI 2.0) each of which pushes the next: FMUs and nothing else.

    With ``is_closed`` the last one pushes the first. The even ones are stepped at ``rate`` (Hz),
    the odd ones at every ``every``-th of its ticks. All positions are recorded.
    """
    parts: list[str] = []
    for number in range(masses):
        values = "mass: 1.0" if number else "mass: 1.0, initial_position: 0.25"
        own = rate // every if number % 2 else rate
        parts.append(
            f"m{number}: {{fmu: hand, flavour: fmi2, feedthrough: true, rate: {own}, "
            f"parameters: {{{values}}}}}"
        )
    wires = [
        f"{{from: m{number}.position, to: m{(number + 1) % masses}.force, unit: ignore}}"
        for number in range(masses if is_closed else masses - 1)
    ]
    return _scenario(f"{ticks}/{rate}", parts, wires, '["*.position"]')


def _scenario(duration: str, parts: list[str], wires: list[str], record: str) -> str:
    lines = ["cohaptic: 1", f"duration: {duration}", f"record: {record}"]
    lines += ["components:", *(f"  {part}" for part in parts)]
    return "\n".join([*lines, "connections:", *(f"  - {wire}" for wire in wires), ""])
