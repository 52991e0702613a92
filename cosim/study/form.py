"""A study's plan as it is written: every key and its meaning."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from cosim.base.document.form import Form, QuantityIn

Seconds = Annotated[float, QuantityIn(unit="s", what="time, such as 20 or '1 min'", least=0)]
Count = Annotated[int, Field(ge=1, le=10_000)]


class ConditionForm(Form):
    """What is different in one condition."""

    scenario: str | None = Field(default=None, description="Another scenario than the study's.")
    sets: list[str] = Field(
        default_factory=list[str], alias="set", description="Values, as --set takes them."
    )


class StaircaseForm(Form):
    """A value that goes down after noticing and up after not noticing (Levitt 1971)."""

    vary: str | list[str] = Field(
        description="The place, or several, that take the value: lan.round_trip_delay, vr_*.mass."
    )
    unit: str = Field(default="", description="Written behind each value.")
    least: float = Field(description="The smallest value.")
    most: float = Field(description="The greatest value.")
    start: float = Field(description="The first value.")
    steps: list[Annotated[float, Field(gt=0)]] = Field(
        min_length=1, description="By how much it changes; the next one after each reversal."
    )
    down: Annotated[int, Field(ge=1, le=4)] = Field(
        default=2, description="How many times in a row it is noticed before it goes down."
    )
    up: Annotated[int, Field(ge=1, le=4)] = Field(
        default=1, description="How many times in a row it is not noticed before it goes up."
    )
    answer: str = Field(description="The yes-or-no question that says whether it is noticed.")


class QuestionForm(Form):
    """One question."""

    ask: str = Field(min_length=1, description="The question as it is shown.")
    kind: Literal["yes_no", "scale", "number", "choice", "text"] = Field(
        default="yes_no", description="What is an answer."
    )
    least: float | None = Field(default=None, description="scale, number: the smallest answer.")
    most: float | None = Field(default=None, description="scale, number: the greatest answer.")
    step: Annotated[float, Field(gt=0)] | None = Field(
        default=None,
        description="scale, number: how far answers lie apart, from the smallest on; a scale: 1.",
    )
    labels: list[str] = Field(
        default_factory=list[str], description="scale: what both ends mean; choice: the answers."
    )


class BreakForm(Form):
    """Rest between trials."""

    every: Count = Field(description="After so many trials.")
    least: Seconds = Field(default=0.0, description="At least so long (s).")


class EmulatedForm(Form):
    """A participant who is none, to try a plan: notices by a logistic function of the value."""

    threshold: dict[str, float] = Field(
        description="By condition: the value that is noticed in half of the trials."
    )
    slope: Annotated[float, Field(gt=0)] = Field(description="How steep, in 1 / value.")


class StudyForm(Form):
    """A cohaptic study."""

    study: Literal[1] = Field(description="The version of the plan's language.")
    title: str = Field(default="", description="What is studied.")
    scenario: str = Field(description="A file, from the plan's folder, or a bundled name.")
    sets: list[str] = Field(
        default_factory=list[str], alias="set", description="Values of all trials."
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(
        default=0, description="What orders and seeds of the trials are drawn from."
    )
    conditions: dict[str, ConditionForm] = Field(min_length=1, description="By name.")
    trials: Count = Field(description="Of each condition.")
    order: Literal["blocked", "interleaved"] = Field(
        default="blocked",
        description="blocked: one condition after another, by a Latin square over participants "
        "(Williams 1949); interleaved: all conditions in each round, shuffled.",
    )
    staircase: StaircaseForm | None = Field(
        default=None, description="One value follows the answers, in each condition for itself."
    )
    questions: dict[str, QuestionForm] = Field(
        default_factory=dict[str, QuestionForm], description="After each trial, by name."
    )
    after_condition: list[Literal["nasa_tlx"]] = Field(
        default_factory=list[Any], description="Forms after a condition's last trial."
    )
    rest: BreakForm | None = Field(default=None, alias="break", description="Rest.")
    emulated: EmulatedForm | None = Field(default=None, description="For --emulate.")
