"""A channel as it is written: its ends, its rate, its delay, and a key for each impairment."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, ClassVar, cast

from pydantic import BaseModel, Discriminator, Field, Tag, create_model, model_validator

from cosim.base.document.form import Form, problem
from cosim.base.errors import InputError
from cosim.scenario.form.both import Both
from cosim.scenario.form.fields import Delay, Name, Rate
from cosim.scenario.impairments.registry import DELAY_FORMS, impairments, replaced_by


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
    link: dict[str, Any] = Field(default_factory=dict, description="Settings of a real link.")

    @model_validator(mode="after")
    def _one_delay(self) -> ChannelForm:
        forms = [form for form in DELAY_FORMS if getattr(self, form) is not None]
        if len(forms) > 1:
            raise problem(f"the delay is given twice: {' and '.join(forms)}; keep one of them.")
        for name in impairments():
            clash = [key for key in replaced_by(name) if getattr(self, key, None) is not None]
            if getattr(self, name, None) is not None and clash:
                raise problem(f"'{name}' stands in place of '{clash[0]}'; keep one of them.")
        return self

    def written(self, impairment: str, side: int) -> Any:
        """What is written of an impairment for a direction: 0 forward, 1 backward, or ``None``."""
        written: Any = getattr(self, impairment)
        if not isinstance(written, Both):
            return written
        both = cast("Both[Any]", written)
        return both.backward if side else both.forward


@cache
def channel_form(link: type[BaseModel] | None = None) -> type[ChannelForm]:
    """The form with a key for every impairment that there is, and ``link`` in its own form.

    Raises:
        InputError: a package brings an impairment that is called like a key of this form.
    """
    if taken := sorted(ChannelForm.model_fields.keys() & impairments().keys()):
        raise InputError(
            f"a package brings an impairment '{taken[0]}', but channels have a key of that name "
            "already; uninstall that package or rename its impairment."
        )
    keys: dict[str, Any] = {
        name: (_entry(name, kind.form) | None, Field(default=None, description=kind.description))
        for name, kind in impairments().items()
    }
    if link is not None:
        said = ChannelForm.model_fields["link"].description
        keys["link"] = (link, Field(default_factory=link, description=said))
    return create_model("ChannelForm", __base__=ChannelForm, __doc__=ChannelForm.__doc__, **keys)


def _entry(name: str, form: Any) -> Any:
    """One value for both directions, or one for each."""
    words = name.split("_")
    both = create_model(
        f"Both{''.join(word.capitalize() for word in words)}",
        __base__=Both[form],
        __doc__=f"{' '.join(words).capitalize()} by direction.",
    )
    return Annotated[
        Annotated[form, Tag("each")] | Annotated[both, Tag("both")], Discriminator(_direction_tag)
    ]


def _direction_tag(value: Any) -> str:
    is_both = isinstance(value, dict) and ("forward" in value or "backward" in value)
    return "both" if is_both else "each"
