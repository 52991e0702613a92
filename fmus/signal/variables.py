"""A signal over time: constant, step, sine, minimum jerk or a table from a file."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.state import words
from fmus.table import Enumeration, Item, Model, ModelVariable

MODE = Enumeration(
    name="signal_mode",
    description="What the signal does over time",
    items=(
        Item(name="constant", value=0, description="offset + amplitude, always"),
        Item(name="step", value=1, description="offset, and amplitude from start_time on"),
        Item(name="sine", value=2, description="offset + amplitude sin(frequency t + phase)"),
        Item(name="minimum_jerk", value=3, description="from offset to offset + amplitude, smooth"),
        Item(name="table", value=4, description="offset + amplitude times a table's values"),
    ),
)


def _number(
    name: str, description: str, unit: str, start: float, *, tunable: bool = False
) -> ModelVariable:
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        tunable=tunable,
        unit=unit,
        start=start,
    )


MODEL = Model(
    name="signal",
    description="A signal over time: constant, step, sine, minimum jerk, table",
    sources=("model.c", "waveform.c"),
    state_ends_in_table=True,
    linear=True,
    state=tuple(words(("time",))),
    variables=(
        ModelVariable(name="value", description="The signal", causality="output", unit=""),
        ModelVariable(name="rate", description="Its time derivative", causality="output", unit=""),
        ModelVariable(
            name="mode",
            description="What the signal does over time",
            causality="parameter",
            type="enumeration",
            enumeration=MODE,
            start=0,
        ),
        _number("amplitude", "What the mode's shape is multiplied by", "", 1.0, tunable=True),
        _number("offset", "What is added", "", 0.0, tunable=True),
        _number("frequency", "Angular frequency of the sine", "rad/s", 1.0),
        _number("phase", "Phase of the sine at start_time", "rad", 0.0),
        _number("start_time", "When step, sine, minimum jerk or table begin", "s", 0.0),
        ModelVariable(
            name="duration",
            description="How long step and sine last (0: without end), or the minimum jerk takes",
            causality="parameter",
            unit="s",
            start=0.0,
            minimum=0.0,
        ),
        ModelVariable(
            name="rectify",
            description="Whether negative values of amplitude times shape become zero",
            causality="parameter",
            type="boolean",
            start=False,
        ),
        ModelVariable(
            name="interpolate",
            description="Whether a table's values are joined by lines, or held",
            causality="parameter",
            type="boolean",
            start=True,
        ),
        ModelVariable(
            name="table_file",
            description="Text file with a time (s) and a value in each line",
            causality="parameter",
            type="string",
            start="",
            meaning=Meaning.FILE,
        ),
    ),
)
