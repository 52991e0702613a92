"""What one packet carries: named fields with units, sizes and the limits that they must keep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Variable, VariableType
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning
from cosim.link.wire.packet import LARGEST_DATAGRAM, datagram_size

Floats = NDArray[np.float64]

LIMITS_BY_UNIT: Mapping[str, tuple[float, float]] = {
    "m": (10.0, 10.0),
    "rad": (1.0e4, 500.0),
    "m/s": (50.0, 5.0e3),
    "rad/s": (1.0e3, 2.0e5),
    "N": (200.0, math.inf),
    "N.m": (50.0, math.inf),
    "J": (1.0e3, math.inf),
}
"""Unit -> (largest magnitude, largest change per second), used where a variable declares no range.

They are an order of magnitude above what a hand can do at a desktop device (about 3 m/s), so that
they stop nonsense and not a fast user.
"""


_EXACT = 2.0**53
_LARGEST_SINGLE = (2.0 - 2.0**-23) * 2.0**127
RANGES: Mapping[VariableType, tuple[float, float]] = {
    VariableType.FLOAT32: (-_LARGEST_SINGLE, _LARGEST_SINGLE),
    VariableType.INT8: (-(2.0**7), 2.0**7 - 1.0),
    VariableType.UINT8: (0.0, 2.0**8 - 1.0),
    VariableType.INT16: (-(2.0**15), 2.0**15 - 1.0),
    VariableType.UINT16: (0.0, 2.0**16 - 1.0),
    VariableType.INT32: (-(2.0**31), 2.0**31 - 1.0),
    VariableType.UINT32: (0.0, 2.0**32 - 1.0),
    VariableType.INT64: (-_EXACT, _EXACT),
    VariableType.UINT64: (0.0, _EXACT),
    VariableType.ENUMERATION: (-(2.0**31), 2.0**31 - 1.0),
    VariableType.BOOLEAN: (0.0, 1.0),
}
"""What a variable's type holds; of 64-bit integers what a float64 holds exactly."""


class FieldRole(StrEnum):
    """What a field means to the link itself, beyond being delivered."""

    VALUE = "value"
    SOURCE_TICK = "source_tick"
    SOURCE_AGE = "source_age"
    STATUS = "status"


ROLES = {
    Meaning.SOURCE_TICK: FieldRole.SOURCE_TICK,
    Meaning.SOURCE_AGE: FieldRole.SOURCE_AGE,
    Meaning.SOURCE_STATUS: FieldRole.STATUS,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """One variable of a bundle; every element travels as a float64.

    ``minimum``, ``maximum`` and ``speed`` (largest change per second) are in ``unit``. Integers are
    exact up to 2**53.
    """

    name: str
    unit: str | None = None
    size: int = 1
    integer: bool = False
    boolean: bool = False
    minimum: float = -math.inf
    maximum: float = math.inf
    speed: float = math.inf
    role: FieldRole = FieldRole.VALUE
    is_relative: bool = False
    """A difference, to which the offset of its unit does not apply."""

    @classmethod
    def of(
        cls,
        variable: Variable,
        name: str | None = None,
        *,
        speed: float | None = None,
    ) -> Field:
        """The field that carries a component's variable, with limits from it or from its unit."""
        meaning = variable.meaning_of()
        role = FieldRole.VALUE if meaning is None else ROLES.get(meaning, FieldRole.VALUE)
        integer = not variable.type.is_float
        magnitude, default_speed = LIMITS_BY_UNIT.get(variable.unit or "", (math.inf, math.inf))
        lowest, highest = RANGES.get(variable.type, (-math.inf, math.inf))
        if not integer:
            lowest, highest = max(lowest, -magnitude), min(highest, magnitude)
        return cls(
            name=name or variable.name,
            unit=variable.unit,
            size=math.prod(variable.shape) if variable.shape else 1,
            integer=integer,
            boolean=variable.type is VariableType.BOOLEAN,
            minimum=lowest if variable.minimum is None else variable.minimum,
            maximum=highest if variable.maximum is None else variable.maximum,
            speed=default_speed if speed is None else speed,
            role=role,
            is_relative=variable.is_relative,
        )

    def describe(self) -> dict[str, Any]:
        """What both stations must agree on, as plain values."""
        return {
            "name": self.name,
            "unit": self.unit or "1",
            "size": self.size,
            "type": "integer" if self.integer else "real",
            "minimum": self.minimum,
            "maximum": self.maximum,
            "speed": self.speed,
            "role": self.role.value,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketBundle:
    """The fields that one station sends to another in one packet.

    ``channel`` is the scenario's name for what it goes through; ``stream`` numbers the bundles of
    one direction from 0; ``period`` is the base ticks from one
    packet to the next, ``tick`` the length of a base tick in seconds.

    Raises:
        InputError: two fields have one name, or the bundle does not fit into one datagram.
    """

    source: str
    target: str
    channel: str = "link"
    fields: tuple[Field, ...]
    period: int
    tick: Fraction
    stream: int = 0

    def __post_init__(self) -> None:
        names = [field.name for field in self.fields]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            message = (
                f"the packet from {self.source} to {self.target} carries {', '.join(twice)} "
                "twice; send each variable once"
            )
            raise InputError(message)
        # 1232 bytes is what IPv6 carries everywhere (1280 less headers); a larger datagram may be
        # split on the way, and one lost fragment loses all of it.
        if datagram_size(self.size) > LARGEST_DATAGRAM:
            message = (
                f"the packet from {self.source} to {self.target} carries {self.size} numbers and "
                f"needs {datagram_size(self.size)} bytes; one datagram holds {LARGEST_DATAGRAM}. "
                "Send fewer variables, or use a second channel"
            )
            raise InputError(message)

    @property
    def size(self) -> int:
        """Number of float64 elements."""
        return sum(field.size for field in self.fields)

    @property
    def slices(self) -> dict[str, slice]:
        """Where each field lies among the elements."""
        places: dict[str, slice] = {}
        start = 0
        for field in self.fields:
            places[field.name] = slice(start, start + field.size)
            start += field.size
        return places

    def spread(self, attribute: str) -> Floats:
        """A field attribute (``minimum``, ``maximum``, ``speed``) for every element, shape (n,)."""
        values = [getattr(field, attribute) for field in self.fields]
        sizes = [field.size for field in self.fields]
        return np.repeat(np.array(values, dtype=np.float64), sizes)

    def indices(self, role: FieldRole) -> list[int]:
        """The elements of all fields of one role."""
        places = self.slices
        return [
            index
            for field in self.fields
            if field.role is role
            for index in range(places[field.name].start, places[field.name].stop)
        ]

    @property
    def head(self) -> list[int]:
        """The elements that say how the source is; they travel also where others are withheld."""
        roles = (FieldRole.SOURCE_TICK, FieldRole.SOURCE_AGE, FieldRole.STATUS)
        return sorted(place for role in roles for place in self.indices(role))

    def describe(self) -> dict[str, Any]:
        """What both stations must agree on, as plain values."""
        return {
            "stream": self.stream,
            "channel": self.channel,
            "period": self.period,
            "tick": str(self.tick),
            "fields": [field.describe() for field in self.fields],
        }
