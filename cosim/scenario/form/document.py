"""The scenario as it is written: every key, its meaning, and the JSON schema for editors.

This is the form after includes, overlays and overrides; ``cosim.scenario.build`` resolves it.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    PlainValidator,
    Tag,
    WithJsonSchema,
    create_model,
    model_validator,
)

from cosim.base.document.form import Form, mapping_tag, problem
from cosim.base.document.show import describe
from cosim.scenario.form.channel import ChannelForm, channel_form
from cosim.scenario.form.fields import (
    Delay,
    Given,
    Hertz,
    Name,
    Pattern,
    Rate,
    Seconds,
    Shift,
    Signal,
    SignalName,
    Span,
)
from cosim.scenario.form.sections import Chosen, Forms, all_of
from cosim.scenario.form.turning import EventForm, KnobForm
from cosim.scenario.source.merge import KINDS, OWNERS
from cosim.scenario.source.notation import NotationError, parse_connection


class DeviceForm(BaseModel):
    """A device with settings besides its URL; which ones is the driver's affair."""

    model_config = ConfigDict(extra="allow", frozen=True)

    url: str = Field(description="Which driver on which port: `haply:///dev/ttyACM0`.")


class ComponentForm(Form):
    """One thing with inputs and outputs: exactly one of fmu, python, device, playback, table."""

    read_before: ClassVar[tuple[str, ...]] = ("include",)
    unknown_in: ClassVar[str] = "parameters"

    description: str = ""
    fmu: str | None = Field(
        default=None, description="A bundled model's name, or the path of an FMI 2 or 3 archive."
    )
    python: str | None = Field(
        default=None,
        description="`module:Class`, `file.py:Class` or a registered name, a Component subclass.",
    )
    device: (
        Annotated[
            Annotated[str, Tag("plain")] | Annotated[DeviceForm, Tag("mapping")],
            Discriminator(mapping_tag),
        ]
        | None
    ) = Field(default=None, description="Hardware: a URL, or a mapping with `url`.")
    playback: str | None = Field(default=None, description="The folder of an earlier run.")
    of: Name | None = Field(
        default=None, description="playback: which component of that run; the same name by default."
    )
    table: str | None = Field(
        default=None, description="A text file: a heading that names columns, a row a time."
    )
    columns: list[str] | None = Field(
        default=None,
        min_length=1,
        description="table: which columns are outputs; all by default.",
    )
    interpolate: Literal["hold", "linear"] | None = Field(
        default=None,
        description="table: between two rows the one before, or the line through them; hold by "
        "default.",
    )
    time_offset: Shift | None = Field(
        default=None, description="table: what is added to its times; 0 by default."
    )
    station: Name = Field(default="main", description="The workstation that computes it.")
    rate: Rate | None = Field(default=None, description="Steps a second.")
    parameters: dict[str, Given] = Field(
        default_factory=dict, description="Parameter values by variable name; groups may nest."
    )
    start: dict[str, Given] = Field(
        default_factory=dict, description="Start values of inputs and states by variable name."
    )
    flavour: Literal["fmi2", "fmi3", "fmi3-arrays"] | None = Field(
        default=None, description="fmu: which archive of a bundled model; fmi3 by default."
    )
    substeps: Annotated[int, Field(ge=1, le=100_000)] | None = Field(
        default=None, description="fmu: doStep calls in one period; 1 by default."
    )
    feedthrough: bool | None = Field(
        default=None,
        description="fmu: whether outputs follow inputs within a tick, as its dependencies say; "
        "true for bundled models, false for others.",
    )
    isolate: Literal["process"] | None = Field(
        default=None,
        description="fmu: `process`: in a process of its own, which may crash; by itself where its "
        "library cannot be shared.",
    )
    event_mode: bool | None = Field(
        default=None,
        description="fmu: whether an FMU of FMI 3 stops at its events and its clocks tick; by "
        "default where it has clocks and event mode.",
    )
    validate_: Literal["lenient", "strict"] | None = Field(
        default=None,
        alias="validate",
        description="fmu: whether rule breaks of its XML are notes or refused; lenient by default.",
    )

    @model_validator(mode="after")
    def _one_kind(self) -> ComponentForm:
        kinds = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(kinds) > 1:
            raise problem(f"one kind too many: {' and '.join(kinds)}; keep one of them.")
        if not kinds:
            *others, last = (f"'{kind}'" for kind in KINDS)
            raise problem(f"it has no kind; give it one of {', '.join(others)} or {last}.")
        for key, owner in OWNERS.items():
            given = self.validate_ if key == "validate" else getattr(self, key)
            if given is not None and kinds[0] != owner:
                raise problem(f"'{key}' belongs to '{owner}', not to '{kinds[0]}'.")
        return self


class ConnectionForm(Form):
    """An output to an input, in full."""

    @model_validator(mode="before")
    @classmethod
    def _has_an_arrow(cls, written: object) -> object:
        pairs = cast("dict[str, Any]", written) if isinstance(written, dict) else {}
        for source, target in pairs.items():
            if "." in source and isinstance(target, str):
                raise problem(f"write '{source} -> {target}', with '->' for ':'.")
        return cast("object", written)

    source: Signal = Field(alias="from", description="component.output")
    target: Signal = Field(alias="to", description="component.input")
    via: Name | None = Field(default=None, description="The channel between two stations.")
    rate: Rate | None = Field(default=None, description="Samples a second.")
    delay: Delay | None = Field(default=None, description="Delay inside a station.")
    initial: Literal["source", "start"] = Field(
        default="source",
        description="Before the first sample: the source's first value, or the input's start.",
    )
    factor: float = Field(
        default=1.0,
        allow_inf_nan=False,
        description="What the value is multiplied by, behind the conversion of units.",
    )
    offset: float = Field(
        default=0.0, allow_inf_nan=False, description="What is added then, in the input's unit."
    )
    unit: Literal["ignore"] | None = Field(
        default=None, description="`ignore`: pass the number as it is, whatever the units say."
    )


def _to_connection(value: Any) -> ConnectionForm:
    if not isinstance(value, str):
        raise problem(f"{describe(value)} is no connection; write 'a.output -> b.input'.")
    try:
        return ConnectionForm.model_validate(parse_connection(value))
    except NotationError as error:
        raise problem(str(error)) from None


_LINE = WithJsonSchema(
    {
        "type": "string",
        "pattern": "->",
        "description": "source.output -> target.input via CHANNEL at RATE delay TIME",
    }
)
ConnectionEntry = Annotated[
    Annotated[ConnectionForm, PlainValidator(_to_connection), _LINE, Tag("plain")]
    | Annotated[ConnectionForm, Tag("mapping")],
    Discriminator(mapping_tag),
]


class RecordForm(Form):
    """Recorded signals at a rate of their own."""

    signals: Pattern = Field(description="A pattern: `vr_a.*`, `finger_??.joint_angle`.")
    rate: Rate | None = Field(default=None, description="Rows a second.")


class Document(Form):
    """A cohaptic scenario."""

    read_before: ClassVar[tuple[str, ...]] = ("include",)

    cohaptic: Literal[1] = Field(description="The version of the scenario language.")
    name: Name | None = Field(default=None, description="Names runs; the file's name by default.")
    title: str = Field(default="", description="One line that says what this is.")
    description: str = Field(default="", description="What it shows and where it comes from.")
    duration: Seconds = Field(description="Simulated time.")
    start_time: Span = Field(
        default=Fraction(0), description="The time of its first tick; a whole number of base ticks."
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(
        default=0, description="What every random draw derives from."
    )
    base_rate: Hertz | None = Field(
        default=None,
        description="Base ticks a second; the least common multiple of the rates by default.",
    )
    rates: dict[Name, Hertz] = Field(default_factory=dict, description="Rates by name.")
    components: dict[Name, ComponentForm] = Field(description="What is computed, by name.")
    channels: dict[Name, ChannelForm] = Field(
        default_factory=dict, description="Networks between stations, by name."
    )
    connections: list[ConnectionEntry] = Field(
        default_factory=list[ConnectionEntry], description="Outputs to inputs."
    )
    knobs: dict[SignalName, KnobForm] = Field(
        default_factory=dict, description="What may be turned while it runs, and how far."
    )
    events: list[EventForm] = Field(
        default_factory=list[EventForm], description="What is turned while it runs, and when."
    )
    record: list[
        Annotated[
            Annotated[Pattern, Tag("plain")] | Annotated[RecordForm, Tag("mapping")],
            Discriminator(mapping_tag),
        ]
    ] = Field(default=["*"], description="Signals to record; everything by default.")
    expect: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="Acceptance by signal; makes the scenario a test."
    )
    safety: dict[str, Any] = Field(default_factory=dict, description="Limits for devices.")
    realtime: dict[str, Any] = Field(default_factory=dict, description="Pacing and its policies.")
    link: dict[str, Any] = Field(default_factory=dict, description="Settings of the UDP link.")


@cache
def document_form(sections: Chosen = ()) -> type[Document]:
    """The document with a key for every impairment in its channels, and the sections' forms."""
    forms = dict(sections)
    channels: Any = dict.__class_getitem__((Name, channel_form(forms.get("link"))))
    description = Document.model_fields["channels"].description
    keys: dict[str, Any] = {}
    for name, form in forms.items():
        kind: Any = dict.__class_getitem__((str, form)) if name == "expect" else form
        empty: Any = dict if name == "expect" else form
        said = Document.model_fields[name].description
        keys[name] = (kind, Field(default_factory=empty, description=said))
    return create_model(
        "Document",
        __base__=Document,
        __doc__=Document.__doc__,
        channels=(channels, Field(default_factory=dict, description=description)),
        **keys,
    )


def json_schema(forms: Forms | None = None) -> dict[str, Any]:
    """The JSON schema of a scenario file, with what editors need besides the document itself."""
    schema = document_form(all_of(forms or {})).model_json_schema(by_alias=True)
    include: dict[str, Any] = {
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]
    }
    include["description"] = "Fragments that lie under this: paths from here, or bundled names."
    for name in ("ComponentForm", "ChannelForm"):
        schema["$defs"][name]["properties"]["include"] = include
        schema["$defs"][name].pop("required", None)
    schema["properties"]["include"] = include
    schema["patternProperties"] = {"^x-": {"description": "Anything: a place for anchors."}}
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "cohaptic scenario"
    return schema
