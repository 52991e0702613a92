"""What is turned while a scenario runs, as it is written: knobs with their ranges, and events."""

from __future__ import annotations

from pydantic import Field

from cosim.base.document.form import Form
from cosim.scenario.form.fields import Given, Instant, SignalName


class KnobForm(Form):
    """Between which values something may be turned."""

    minimum: Given | None = Field(
        default=None, description="The least; for a channel 0, else what its component declares."
    )
    maximum: Given | None = Field(default=None, description="The most, likewise.")


class EventForm(Form):
    """What is turned at one instant."""

    at: Instant = Field(
        description="When: the model's time (s), or base ticks since the start ('64 ticks')."
    )
    set_: dict[SignalName, Given] = Field(
        alias="set", min_length=1, description="The new values: `component.parameter`, `lan.delay`."
    )
