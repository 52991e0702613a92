"""Choices that a workstation is given or tells: enumerations."""

from __future__ import annotations

from fmus.table import Enumeration, Item

CONTACT_STATE = Enumeration(
    name="ContactState",
    description="State of a contact (thesis, figure 7.4)",
    items=(
        Item(name="free", value=0, description="No contact"),
        Item(
            name="moment_cancellation",
            value=1,
            description="Impulses of the largest force take the hand's momentum",
        ),
        Item(name="pre_slide", value=2, description="Sticking: springs along both directions"),
        Item(name="slide", value=3, description="Sliding under kinetic friction"),
    ),
)


VELOCITY_ESTIMATOR = Enumeration(
    name="VelocityEstimator",
    description="How the tip's velocity comes from sampled joint angles",
    items=(
        Item(
            name="foaw",
            value=0,
            description="First-order adaptive windowing on the joint angles, end fit, one quantum",
        ),
        Item(
            name="finite_difference",
            value=1,
            description="Difference of the tip position over the whole window",
        ),
    ),
)


PASSIVITY = Enumeration(
    name="Passivity",
    description="Whether the rendered force is kept passive",
    items=(
        Item(name="none", value=0, description="The force is rendered as it is"),
        Item(
            name="time_domain",
            value=1,
            description="Passivity observer and controller (Hannaford and Ryu, 2002)",
        ),
    ),
)


FORCE_CHANNEL = Enumeration(
    name="ForceChannel",
    description="What carries hand and force between a client and its server",
    items=(
        Item(name="plain", value=0, description="Position and velocity up, force down (thesis)"),
        Item(
            name="wave",
            value=1,
            description="Wave variables both ways (Niemeyer and Slotine, 1991)",
        ),
    ),
)
