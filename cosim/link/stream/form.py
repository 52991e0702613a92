"""``link:`` of a scenario or a channel as it is written; ``settings`` are what is obeyed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from cosim.base.document.form import Form, QuantityIn

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
Seconds = Annotated[
    float, QuantityIn(unit="s", what="time, such as 0.5 or '50 ms'", above=0, most=60)
]


def _delay_tag(value: Any) -> str:
    return "auto" if value == "auto" else "samples"


Delay = Annotated[
    Annotated[Literal["auto"], Tag("auto")] | Annotated[Samples, Tag("samples")],
    Discriminator(_delay_tag),
]


class LinkForm(Form):
    """How a real link behaves; a channel's `link` goes over the scenario's."""

    release: Literal["network_tick", "arrival"] | None = Field(
        default=None, description="When a packet's values are taken over."
    )
    delay: Delay | None = Field(
        default=None, description="Least delay in samples, or `auto`: measured before the start."
    )
    max_delay: Samples | None = Field(
        default=None, description="Longest way in samples after which values still count."
    )
    clock: Literal["follow", "free"] | None = Field(
        default=None, description="What keeps the stations' ticks together."
    )
    add_impairments: bool | None = Field(
        default=None, description="Whether the channel's impairments come on top of the link's."
    )
    hold_samples: Samples | None = Field(
        default=None, description="Missing samples that are held in full before the fade."
    )
    hold: Seconds | None = Field(
        default=None, description="Bounds the hold where the samples last longer (s)."
    )
    fade: Seconds | None = Field(default=None, description="How long a lost peer fades out (s).")
    resume: Seconds | None = Field(default=None, description="How long it comes back (s).")
    resume_samples: Samples | None = Field(
        default=None, description="Good samples in a row before it comes back."
    )
    ramp_at_start: bool | None = Field(
        default=None, description="Whether the first session ramps up, too."
    )
