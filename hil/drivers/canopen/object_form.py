"""One joint's object of a node, as a device file names it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cosim.base.document.form import Form, QuantityIn
from hil.drivers.canopen.protocol import LAST_NODE


class ObjectForm(Form):
    """One joint's encoder or output: an object of a node."""

    node: Annotated[
        int,
        QuantityIn(
            unit="1",
            what=f"node number of 1 to {LAST_NODE}",
            least=1,
            most=LAST_NODE,
            whole=True,
        ),
    ] = Field(description="The node's number.")
    object: (
        Annotated[
            int,
            QuantityIn(
                unit="1",
                what="whole number from 0x6000 to 0x9fff",
                least=0x6000,
                most=0x9FFF,
                whole=True,
            ),
        ]
        | None
    ) = Field(default=None, description="The object's index; the profile's first by default.")
    channel: (
        Annotated[
            int,
            QuantityIn(unit="1", what="whole number from 0 to 254", least=0, most=254, whole=True),
        ]
        | None
    ) = Field(default=None, description="Its subindex; an encoder's 0, an output's 1 by default.")
