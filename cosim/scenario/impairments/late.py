"""What reorder and duplication have in common: some packets, and how much later they come."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from cosim.base.document.form import Form, mapping_tag
from cosim.scenario.form.fields import Delay, Lag, Probability
from cosim.scenario.impairments.impairment import Setting


class LateForm(Form):
    """Packets picked at random that arrive (again) later."""

    probability: Probability
    by: Delay | None = Field(default=None, description="How much later.")


LATE = Annotated[
    Annotated[Probability, Tag("plain")] | Annotated[LateForm, Tag("mapping")],
    Discriminator(mapping_tag),
]


@dataclass(frozen=True, slots=True)
class Late:
    """How probable it is for a packet, and how many ticks later."""

    probability: float
    ticks: int

    @classmethod
    def of(cls, written: Any, by: Lag, setting: Setting) -> Late | None:
        """What is written, ``by`` where it does not say; ``None`` for a probability of 0."""
        if isinstance(written, LateForm):
            probability, by = written.probability, written.by or by
        else:
            probability = written
        return cls(probability, setting.ticks(by)) if probability else None

    def write(self) -> dict[str, Any]:
        """As it may be written."""
        return {
            "probability": self.probability,
            "by": "1 tick" if self.ticks == 1 else f"{self.ticks} ticks",
        }
