"""``realtime:`` of a scenario: how a paced run keeps pace; the command line wins over it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cosim.base.document.form import Form, QuantityIn


class RealtimeForm(Form):
    """How a run keeps pace with the clock."""

    on_miss: Literal["count", "stop"] | None = Field(
        default=None, description="What a missed deadline means; count by default."
    )
    cpu: (
        Annotated[
            int, QuantityIn(unit="1", what="processor's number", least=0, most=4095, whole=True)
        ]
        | None
    ) = Field(default=None, description="Processor of the control loop; a little used one.")
