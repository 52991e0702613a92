"""What may be written in two ways: once, or for each direction."""

from __future__ import annotations

from typing import Generic, TypeVar

from pydantic import Field

from cosim.base.document.form import Form

T = TypeVar("T")


class Both(Form, Generic[T]):
    """One value for each direction; forward is from the first end in ``between``."""

    forward: T | None = Field(default=None, description="From the first end of `between`.")
    backward: T | None = Field(default=None, description="Towards the first end of `between`.")
