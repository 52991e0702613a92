"""Virtual couplers of fingers and of copies of the box, and the damping compensation."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.shared.workstation.short_forms import choice, real, switch
from fmus.table import Enumeration, Group, Item, ModelVariable

PUSH = Enumeration(
    name="Push",
    description="What the box is pushed with by an own finger whose force is cut at max_force",
    items=(
        Item(name="wanted", value=0, description="The contact's whole force (thesis)"),
        Item(
            name="rendered",
            value=1,
            description="What the hand is given, so that both have the same",
        ),
    ),
)


Coupler = tuple[float, float, float, float]
"""Normal stiffness and damping, tangential stiffness and damping (N/m, N.s/m)."""


TABLE_8_1: Coupler = (800.0, 3.0, 1200.0, 10.0)


REMOTE_8_2: Coupler = (170.0, 3.0, 270.0, 5.0)


OUR_SET = (
    "Our choice: the thesis's Table 8.2 is lost; these carry the box at 0 to 2 samples of delay"
)


def _surface(prefix: str, who: str, values: Coupler, source: str) -> tuple[ModelVariable, ...]:
    names = (
        ("normal_stiffness", "Stiffness along the normal", "N/m"),
        ("normal_damping", "Damping along the normal", "N.s/m"),
        ("tangential_stiffness", "Stiffness along the face while sticking", "N/m"),
        ("tangential_damping", "Damping along the face while sticking", "N.s/m"),
    )
    return tuple(
        real(
            f"{prefix}_{name}",
            f"{description} of {who}. {source}",
            unit,
            value,
            minimum=0.0,
            tunable=True,
        )
        for (name, description, unit), value in zip(names, values, strict=True)
    )


def coupler_parameters(
    local: Coupler, remote: Coupler, local_source: str, remote_source: str
) -> tuple[ModelVariable, ...]:
    """Virtual couplers between fingers and box and their friction."""
    return (
        *_surface("local", "the own fingers' couplers", local, local_source),
        *_surface("remote", "the remote fingers' couplers", remote, remote_source),
        real(
            "static_friction",
            "Static friction of fingers on the box (thesis 8.1)",
            "1",
            0.6,
            meaning=Meaning.STATIC_FRICTION,
        ),
        real("kinetic_friction", "Kinetic friction of fingers on the box (thesis 8.1)", "1", 0.6),
        real(
            "slide_threshold",
            "Speed v_tr below which a slide ends; above the velocity estimate's noise (chosen)",
            "m/s",
            0.005,
            minimum=0.0,
        ),
        switch(
            "moment_cancellation",
            "Whether own fingers that hit the box are stopped by impulses (eqs. 7.1, 7.2)",
        ),
        choice(
            "box_is_pushed_with",
            "What the box is pushed with where a finger's force is cut at max_force",
            PUSH,
        ),
        real(
            "hand_mass",
            "Mass m_h of hand and device whose momentum the impulses take (thesis, chapter 5)",
            "kg",
            0.1,
            minimum=0.0,
        ),
    )


def _tuned(name: str, description: str, unit: str, start: float) -> ModelVariable:
    """A real parameter that may change while it runs."""
    return real(name, description, unit, start, tunable=True)


def coupling_parameters() -> tuple[ModelVariable, ...]:
    """K_o, B_o between copies of the box and the damping compensation."""
    return (
        _tuned("coupling_stiffness", f"K_o between copies of the box. {OUR_SET}", "N/m", 77.5),
        _tuned("coupling_damping", f"B_o between copies of the box. {OUR_SET}", "N.s/m", 10.0),
        _tuned("coupling_rotational_stiffness", f"K_oR between copies. {OUR_SET}", "N.m/rad", 2.2),
        _tuned("coupling_rotational_damping", f"B_oR between copies. {OUR_SET}", "N.m.s/rad", 0.05),
        real(
            "coupling_force_limit",
            "Largest force between two copies of the box; 0: none",
            "N",
            0.0,
            minimum=0.0,
            tunable=True,
        ),
        real(
            "coupling_torque_limit",
            "Largest torque between two copies of the box; 0: none",
            "N.m",
            0.0,
            minimum=0.0,
            tunable=True,
        ),
    )


def compensation_group() -> Group:
    """b_c of each axis."""
    text = "Added damping b_c, a force sampled from the box's own velocity; negative compensates"
    return Group(
        "compensation",
        (
            _tuned("x", f"{text}; x", "N.s/m", 0.0),
            _tuned("y", f"{text}; y", "N.s/m", 0.0),
            _tuned("theta", f"{text}; about z", "N.m.s/rad", 0.0),
        ),
    )
