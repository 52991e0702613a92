"""A ring of masses joined by virtual couplers: a scenario of any size, every part of it alike."""

from __future__ import annotations


def ring_scenario(components: int, *, ticks: int = 1024, record: str = "[]") -> str:
    """The YAML of a ring of ``components`` parts (an even number), half masses, half couplers.

    All of them run at 1024 Hz, for ``ticks`` ticks; ``record`` is the text of that section.
    """
    pairs = components // 2
    lines = [
        "cohaptic: 1",
        f"duration: {ticks / 1024!r}",
        "rates: {control: 1024 Hz}",
        f"record: {record}",
        "components:",
    ]
    for number in range(pairs):
        place = 1.0 + 0.1 * (number % 7)
        lines += [
            f"  mass_{number}:",
            "    fmu: hand",
            "    station: bench",
            "    rate: control",
            f"    parameters: {{mass: 0.5, initial_position: {place}}}",
            f"  coupler_{number}:",
            "    fmu: virtual_coupler",
            "    station: bench",
            "    rate: control",
            "    parameters: {stiffness: 300.0, damping: 2.0}",
        ]
    lines.append("connections:")
    for number in range(pairs):
        after = (number + 1) % pairs
        lines += [
            f"  - mass_{number}.position -> coupler_{number}.position_a",
            f"  - mass_{number}.velocity -> coupler_{number}.velocity_a",
            f"  - mass_{after}.position -> coupler_{number}.position_b",
            f"  - mass_{after}.velocity -> coupler_{number}.velocity_b",
            f"  - coupler_{number}.reaction -> mass_{number}.force",
            f"  - coupler_{number}.force -> mass_{after}.coupler_force",
        ]
    return "\n".join([*lines, ""])
