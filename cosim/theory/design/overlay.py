"""A design as a scenario overlay."""

from __future__ import annotations

from cosim.theory.design.search import Design
from cosim.theory.models.parameters import Parameters


def overlay(parameters: Parameters, found: Design) -> str:
    """The design as a scenario overlay (YAML) for the single-axis scenarios."""
    gains, users = found.gains, range(1, parameters.users + 1)
    lines = [
        "# Gains designed for a measured network.",
        f"# Nearest to instability: {found.worst} (radius {found.corners[found.worst]:.4f}).",
        *(f"# {name} is limited by: {cause}." for name, cause in found.limited_by.items()),
        "components:",
    ]

    def coupler(name: str, k: str, b: str) -> None:
        values = f"{{stiffness: {gains[k]:.6g}, damping: {gains[b]:.6g}}}"
        lines.append(f"  {name}: {{parameters: {values}}}")

    if parameters.architecture == "centralized":
        for m in users:
            coupler(f"coupler_{m}", f"k_{min(m, 2)}", f"b_{min(m, 2)}")
        lines.append(f"  object: {{parameters: {{compensation: {found.compensation:.6g}}}}}")
    else:
        for m in users:
            coupler(f"coupler_{m}{m}", "k_11", "b_11")
            for r in users:
                if r != m:
                    coupler(f"coupler_{m}{r}", "k_12", "b_12")
            coupler(f"coupler_o{m}", "k_o", "b_o")
            lines.append(
                f"  object_{m}: {{parameters: {{compensation: {found.compensation:.6g}}}}}"
            )
    return "\n".join(lines) + "\n"
