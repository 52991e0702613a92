"""A channel as it is written: delay, jitter, loss, reorder, duplication, once or by direction."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Generic, TypeVar

from pydantic import Discriminator, Field, Tag, model_validator

from cosim.base.form import Form, problem
from cosim.scenario.form.fields import Delay, Name, Packet, Probability, Rate, Span
from cosim.scenario.source.merge import DELAY_FORMS, TRACED

T = TypeVar("T")


class Both(Form, Generic[T]):
    """One value for each direction; forward is from the first end in ``between``."""

    forward: T | None = Field(default=None, description="From the first end of `between`.")
    backward: T | None = Field(default=None, description="Towards the first end of `between`.")


def _direction_tag(value: Any) -> str:
    is_both = isinstance(value, dict) and ("forward" in value or "backward" in value)
    return "both" if is_both else "each"


def mapping_tag(value: Any) -> str:
    """Whether a value is written as a mapping or plainly."""
    return "mapping" if isinstance(value, dict) else "plain"


def _jitter_tag(value: Any) -> str:
    if not isinstance(value, dict):
        return "plain"
    return "weights" if "weights" in value else "rms"


class GilbertElliottForm(Form):
    """Loss in bursts: a chain of a good and a bad state that moves once a packet."""

    good_to_bad: Probability
    bad_to_good: Probability
    loss_good: Probability = 0.0
    loss_bad: Probability = 1.0


class RmsJitter(Form):
    """Extra delay of whole base ticks with this standard deviation."""

    rms: Span


class WeightedJitter(Form):
    """Extra delay of i steps with probability weights[i]; the weights are scaled to sum to one."""

    weights: Annotated[list[Probability], Field(min_length=1, max_length=10_000)]
    step: Delay | None = Field(default=None, description="One step; one sample unless given.")


class LateForm(Form):
    """Packets picked at random that arrive (again) later."""

    probability: Probability
    by: Delay | None = Field(default=None, description="How much later.")


Loss = Annotated[
    Annotated[Probability, Tag("plain")] | Annotated[GilbertElliottForm, Tag("mapping")],
    Discriminator(mapping_tag),
]
Jitter = Annotated[
    Annotated[Delay, Tag("plain")]
    | Annotated[RmsJitter, Tag("rms")]
    | Annotated[WeightedJitter, Tag("weights")],
    Discriminator(_jitter_tag),
]
Late = Annotated[
    Annotated[Probability, Tag("plain")] | Annotated[LateForm, Tag("mapping")],
    Discriminator(mapping_tag),
]


def _trace_tag(value: Any) -> str:
    return "inline" if isinstance(value, list) else "file"


Trace = Annotated[
    Annotated[str, Tag("file")]
    | Annotated[list[Packet], Field(min_length=1, max_length=10_000_000), Tag("inline")],
    Discriminator(_trace_tag),
]


class BothJitter(Both[Jitter]):
    """Jitter by direction."""


class BothLoss(Both[Loss]):
    """Loss by direction."""


class BothLate(Both[Late]):
    """Reorder or duplication by direction."""


class BothTrace(Both[Trace]):
    """A trace by direction."""


_BY = Discriminator(_direction_tag)
JitterEntry = Annotated[Annotated[Jitter, Tag("each")] | Annotated[BothJitter, Tag("both")], _BY]
LossEntry = Annotated[Annotated[Loss, Tag("each")] | Annotated[BothLoss, Tag("both")], _BY]
LateEntry = Annotated[Annotated[Late, Tag("each")] | Annotated[BothLate, Tag("both")], _BY]
TraceEntry = Annotated[Annotated[Trace, Tag("each")] | Annotated[BothTrace, Tag("both")], _BY]


class DelayBoth(Form):
    """The delay of each direction."""

    forward: Delay = Field(description="From the first end of `between`.")
    backward: Delay = Field(description="Towards the first end of `between`.")


class ChannelForm(Form):
    """What values cross between two stations; impairments are drawn for each packet."""

    read_before: ClassVar[tuple[str, ...]] = ("include",)

    description: str = ""
    between: Annotated[list[Name], Field(min_length=2, max_length=2)] = Field(
        description="The two stations; forward is from the first to the second."
    )
    rate: Rate | None = Field(default=None, description="Packets a second.")
    delay: DelayBoth | None = Field(default=None, description="Delay by direction.")
    round_trip_delay: Delay | None = Field(
        default=None, description="n there and back: forward gets the larger half."
    )
    each_way_delay: Delay | None = Field(default=None, description="n there and n back.")
    jitter: JitterEntry | None = Field(
        default=None, description="Extra delay, uniform from 0 to this."
    )
    loss: LossEntry | None = Field(default=None, description="Probability of loss, or bursts.")
    reorder: LateEntry | None = Field(default=None, description="Packets held back, two samples.")
    duplication: LateEntry | None = Field(default=None, description="Packets that come twice.")
    trace: TraceEntry | None = Field(
        default=None,
        description="Recorded delays, in place of delay, jitter and loss: a list, or a file with "
        "a delay in seconds or `lost` in each line.",
    )
    link: dict[str, Any] = Field(default_factory=dict, description="Settings of a real link.")

    @model_validator(mode="after")
    def _one_delay(self) -> ChannelForm:
        forms = [form for form in DELAY_FORMS if getattr(self, form) is not None]
        if len(forms) > 1:
            raise problem(f"the delay is given twice: {' and '.join(forms)}; keep one of them.")
        clash = [key for key in TRACED if getattr(self, key) is not None]
        if self.trace is not None and clash:
            raise problem(f"'trace' stands in place of '{clash[0]}'; keep one of them.")
        return self
