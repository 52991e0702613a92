"""``link:`` of a scenario or a channel: what is written, and what is obeyed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from cosim.base.document.form import Form, QuantityIn, plain_node, problem, read_form
from cosim.base.errors import Location

LONGEST_DELAY = 16
"""Samples, where neither the scenario nor its theory says how long the way may be."""

LONGEST_WAIT = 1024
"""Samples that a packet may be told to wait for its own: eight seconds at 128 Hz."""

Samples = Annotated[
    int,
    QuantityIn(
        unit="1",
        what="whole number of samples, such as 4",
        least=1,
        most=10**6,
        whole=True,
    ),
]
Wait = Annotated[
    int,
    QuantityIn(
        unit="1",
        what="whole number of samples, such as 4",
        least=1,
        most=LONGEST_WAIT,
        whole=True,
    ),
]
Seconds = Annotated[
    float, QuantityIn(unit="s", what="time, such as 0.5 or '50 ms'", above=0, most=60)
]


def _delay_tag(value: Any) -> str:
    return "auto" if value == "auto" else "samples"


Delay = Annotated[
    Annotated[Literal["auto"], Tag("auto")] | Annotated[Wait, Tag("samples")],
    Discriminator(_delay_tag),
]


class LossPolicy(Form):
    """When a peer is given up and how it comes back."""

    hold_samples: Samples = Field(
        default=4,
        description="Samples that may be missing, and that a source may be stale, before the fade.",
    )
    hold: Seconds = Field(default=0.03125, description="Bound of that time.")
    fade: Seconds = Field(default=0.05, description="Time in which `peer_weight` goes to 0.")
    resume: Seconds = Field(default=1.0, description="Time in which it goes back to 1.")
    resume_samples: Samples = Field(
        default=16, description="Good samples in a row before a lost peer comes back."
    )
    ramp_at_start: bool = Field(
        default=False,
        description="Whether the first session waits for good samples and ramps up, too: "
        "there is a hand already.",
    )


class LinkForm(LossPolicy):
    """How a real link behaves; a channel's `link` goes over the scenario's."""

    release: Literal["network_tick", "arrival"] = Field(
        default="network_tick", description="When a packet's values are taken over."
    )
    delay: Delay = Field(
        default=1,
        description="Least delay in samples, for which packets that come sooner wait: more of it "
        "absorbs more jitter. `auto`: what nine packets of ten need, measured before the start.",
    )
    max_delay: Samples | None = Field(
        default=None,
        description="Longest way in samples that may count; without it as the theory says, else "
        f"{LONGEST_DELAY}.",
    )
    clock: Literal["follow", "free"] = Field(
        default="follow",
        description="Whether the stations' ticks are held together: the station whose name sorts "
        "first leads, the others slew their period. `free`: each keeps its own.",
    )
    add_impairments: bool = Field(
        default=False,
        description="Whether the channel's simulated delay, jitter and loss come on top of the "
        "real link's.",
    )

    @model_validator(mode="after")
    def _delays_agree(self) -> LinkForm:
        if self.release == "arrival" and self.delay != 1:
            raise problem(
                f"release: arrival shows values as they come, and delay: {self.delay} lets them "
                "wait for their sample; keep one of them."
            )
        if self.max_delay is not None and self.max_delay < self.least_delay:
            raise problem(
                f"max_delay {self.max_delay} is less than delay {self.delay}: every packet waits "
                "longer than it may; raise max_delay or lower delay."
            )
        return self

    @property
    def least_delay(self) -> int:
        """Samples; one where it is chosen before the start."""
        return self.delay if isinstance(self.delay, int) else 1

    @property
    def longest_wait(self) -> int:
        """Samples; what is chosen before the start is no more."""
        most = min(self.longest_delay, LONGEST_WAIT)
        return self.delay if isinstance(self.delay, int) else most

    @property
    def longest_delay(self) -> int:
        """The longest way in samples after which a packet's values may still be used."""
        return self.max_delay or max(LONGEST_DELAY, self.least_delay)


def read_link(options: Mapping[str, Any], where: str) -> LinkForm:
    """The settings in a mapping; ``where`` names the place.

    Raises:
        InputError: unknown names, or values that make no sense.
    """
    return read_form(LinkForm, plain_node(options, Location(where, 0, 0)), "'link'")
