"""Rows of a record group as ROS 2 messages: a topic for a group, a message for a row.

The encoding is CDR, little-endian, every field of eight bytes, so a row is a record of a NumPy
array behind the four bytes that name the encoding (OMG DDS-RTPS 2.5, section 10.5).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"


@dataclass(frozen=True, slots=True)
class RowMessage:
    """How the rows of one group are written: ``tick``, ``time`` (s), and each signal's field."""

    group: str
    fields: tuple[str, ...]
    floats: tuple[bool, ...]

    @classmethod
    def of(cls, group: str, signals: Sequence[str], floats: Sequence[bool]) -> Self:
        """The message of a group that records ``signals``; the others are integers of 64 bits."""
        return cls(group, tuple(ros_names(signals)), tuple(floats))

    @property
    def topic(self) -> str:
        """Where its messages come."""
        return f"/{self.group}"

    @property
    def schema_name(self) -> str:
        """``package/msg/Type``."""
        return f"cohaptic/msg/{self.group.title().replace('_', '')}"

    @property
    def definition(self) -> str:
        """Its fields, as a ROS 2 message is defined."""
        kinds = ["float64" if is_float else "int64" for is_float in self.floats]
        fields = [("tick", "int64"), ("time", "float64"), *zip(self.fields, kinds, strict=True)]
        return "".join(f"{kind} {name}\n" for name, kind in fields)

    @property
    def row(self) -> np.dtype[Any]:
        """A message without the bytes that name its encoding."""
        kinds = ["<f8" if is_float else "<i8" for is_float in self.floats]
        return np.dtype([("tick", "<i8"), ("time", "<f8"), *zip(self.fields, kinds, strict=True)])


def ros_names(names: Sequence[str]) -> list[str]:
    """Field names of ROS 2: ``vr_a.finger_1.force[2]`` becomes ``vr_a_finger_1_force_2``.

    Lower case, single underscores, a letter first; equal ones end in a number.
    """
    found: list[str] = []
    taken = {"tick", "time"}
    for name in names:
        plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
        plain = plain if plain[:1].isalpha() else f"x_{plain}".rstrip("_")
        unique, number = plain, 1
        while unique in taken:
            number += 1
            unique = f"{plain}_{number}"
        taken.add(unique)
        found.append(unique)
    return found
