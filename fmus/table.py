"""How a model describes its variables, once.

From one ``Model`` come the C header (``<model>_variables.h``), both modelDescription.xml files, the
terminals, the documentation table and the device contract. Every numeric element takes one 8-byte
slot (``double`` or ``int64_t``), a string takes a fixed number of slots; the value reference is the
slot's index, so getting, setting and serialising the state is one memcpy.

A ``Group`` gives its members a dotted prefix: ``Group("finger", count=2, ...)`` makes
``finger_1.position[1]`` … in FMI and ``v->finger[0].position[0]`` in C; without ``count``,
``Group("box_pose", ...)`` makes ``box_pose.x`` and ``v->box_pose.x``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from cosim.base.meaning import Meaning
from fmus.state import Kept

Type = Literal["real", "integer", "boolean", "enumeration", "string"]
Causality = Literal["parameter", "calculatedParameter", "input", "output", "local"]
Numbered = Literal["peer", "finger"]
Role = Literal["actuated", "measured", "derived", "simulation_only"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """One named value of an enumeration."""

    name: str
    value: int
    description: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Enumeration:
    """A closed list of named integers."""

    name: str
    description: str
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelVariable:
    """One variable; ``size`` makes it a one-dimensional array.

    ``depends_on`` names the inputs that an output depends on directly (feedthrough), as paths from
    the model's root with ``fnmatch`` wildcards (``finger_1.joint_angle``, ``peer_*.weight``);
    ``{group}`` stands for the variable's own group (``{group}.joint_angle``).
    ``initial_depends_on`` names inputs that it depends on in initialisation mode only (an estimator
    that is primed).
    ``unit`` is an FMI unit string made of SI units (``N.m``, ``N.s/m``, ``rad``), ``1`` for pure
    numbers, empty for what takes the unit of whatever it is connected to. A parameter is ``fixed``
    unless it is ``tunable``: then it may change between two steps. ``start`` is a scalar (for every
    element) or a tuple.
    ``meaning`` is what others look for; an array may have one for each element. ``finger`` and
    ``peer`` number what it belongs to, where the group around it does not; ``each`` says that the
    elements of an array are numbered so.
    """

    name: str
    description: str
    causality: Causality
    tunable: bool = False
    type: Type = "real"
    unit: str | None = None
    start: float | int | bool | str | tuple[float, ...] | None = None
    minimum: float | None = None
    maximum: float | None = None
    size: int | None = None
    enumeration: Enumeration | None = None
    role: Role | None = None
    meaning: Meaning | tuple[Meaning, ...] | None = None
    finger: int | None = None
    peer: int | None = None
    each: Numbered | None = None
    depends_on: tuple[str, ...] = ()
    initial_depends_on: tuple[str, ...] = ()

    @property
    def is_array(self) -> bool:
        """Whether FMI 3.0 may have it as one variable with a dimension.

        Not an enumeration: the schema of 3.0.0, which checkers still have, forbids that by an
        oversight (3.0.1 mended it), and annotations of an enumeration, too.
        """
        return self.size is not None and self.enumeration is None

    @property
    def variability(self) -> str:
        """When the value may change (FMI 2.0 section 2.2.7, FMI 3.0 section 2.4.7.4)."""
        if self.causality in {"parameter", "calculatedParameter"}:
            return "tunable" if self.tunable else "fixed"
        return "continuous" if self.type == "real" else "discrete"


@dataclass(frozen=True, slots=True)
class Group:
    """Variables under a common prefix, repeated ``count`` times where that is given.

    ``numbers`` says what the members belong to: the peer or finger of the group's number, or the
    first one without ``count``.
    """

    name: str
    members: tuple[ModelVariable | Group, ...]
    count: int | None = None
    numbers: Numbered | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Terminal:
    """A bundle that is connected as one: member name -> variable path (both may be arrays)."""

    name: str
    description: str
    members: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model: its variables and the C sources beside it and in ``fmus/shared``.

    ``sources`` are file names, each beside the description or in ``fmus/shared``.
    ``variable_step`` says whether steps of different length may follow each other; where it is
    false, the first step's length is enforced. ``default_step`` is in seconds. ``work_bytes`` is
    the room that ``model_outputs`` has for what ``model_step`` can use again (``model.h``).
    ``state_ends_in_table``: the model says itself how much of its state is in use. ``state`` lists
    what of it changes (``fmus.state``); a model without is none that the theory can perturb.
    ``linear``: outputs and steps are linear in inputs and state, so that any step is exact.
    ``ideal`` holds the values of the parameters at which everything without a derivative is gone;
    ``"window"`` stands for the window that velocities are then estimated over. ``damped`` holds
    values that bring the model to rest where it would rest anyway.
    ``tables`` are constants that the C side is given: a name -> rows of equal length.
    ``retunes``: the model has copies of tunable parameters in its state, and ``model_retune``.
    """

    name: str
    description: str
    variables: tuple[ModelVariable | Group, ...]
    sources: tuple[str, ...]
    terminals: tuple[Terminal, ...] = field(default=())
    version: str = "1"
    variable_step: bool = True
    default_step: float = 1 / 1024
    work_bytes: int = 0
    state_ends_in_table: bool = False
    retunes: bool = False
    state: tuple[Kept, ...] = ()
    linear: bool = False
    ideal: Mapping[str, float | int | str] = field(default_factory=dict[str, float | int | str])
    damped: Mapping[str, float] = field(default_factory=dict[str, float])
    tables: Mapping[str, tuple[tuple[float, ...], ...]] = field(
        default_factory=dict[str, tuple[tuple[float, ...], ...]]
    )
