"""A sweep's plan as it is written: every key and its meaning."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from cosim.base.document.form import Form

Written = int | float | str | bool


class AxisForm(Form):
    """One variable, the places that take its value, and its values."""

    set: str | list[str] | None = Field(
        default=None,
        description="Where the value goes: vr_*.mass, lan.loss, a whole path, or several of them; "
        "the variable's own name by default.",
    )
    values: str | list[Written] = Field(
        description="A list, or a range: 0..39, 0..1:0.1 (a step), 0..20 ms/5 (points), "
        "1..100/7 log."
    )


class PlanForm(Form):
    """A cohaptic sweep."""

    any_other: ClassVar[Any] = None

    sweep: Literal[1] = Field(description="The version of the plan's language.")
    scenario: str = Field(description="A file, from the plan's folder, or a bundled name.")
    overlays: list[str] = Field(
        default_factory=list[str], alias="with", description="Files to lay over it."
    )
    sets: list[str] = Field(
        default_factory=list[str],
        alias="set",
        description="Values to change in all runs, as --set takes them.",
    )
    vary: dict[str, AxisForm | str | list[Written]] = Field(
        default_factory=dict[str, AxisForm | str | list[Written]],
        description="Variables by name, or places with their values.",
    )
    seeds: Annotated[int, Field(ge=1, le=1_000_000)] | None = Field(
        default=None, description="Repeat every point with the seeds 1 to this."
    )
    sample: Literal["grid", "latin_hypercube", "sobol"] = Field(
        default="grid", description="How points are chosen from the ranges."
    )
    points: Annotated[int, Field(ge=1, le=1_000_000)] | None = Field(
        default=None, description="How many points a Latin hypercube or a Sobol sequence has."
    )
    sample_seed: Annotated[int, Field(ge=0, lt=2**63)] | None = Field(
        default=None, description="What the points of a sample are drawn from; 0 unless given."
    )
    boundary: bool = Field(
        default=False,
        description="Run a grid of two variables only where good turns into failed.",
    )
    start: str | int | float | None = Field(
        default=None,
        description="The time from which runs differ; what comes before is run once.",
    )
    expect: dict[str, Any] = Field(
        default_factory=dict[str, Any], description="Expectations, laid over the scenario's."
    )
    measure: dict[str, str | list[str]] = Field(
        default_factory=dict[str, str | list[str]],
        description="More to measure: a signal, a difference or a length, and max_abs, rms, …",
    )
    check_every: Annotated[int, Field(ge=0)] = Field(
        default=100,
        description="Of so many runs one is repeated from nothing and compared; 0: none.",
    )
