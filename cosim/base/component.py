"""The component protocol: what the master, Python models and devices agree on.

A component has named, typed, unit-carrying variables and a period in ticks. The master binds each
input and output to a NumPy view of its own signal buffer once; after that nothing is allocated or
copied by name. At tick k the master calls, in this order (each only when the component is due):

1. ``read(k)``      a device takes its measurements; a model does nothing.
2. ``evaluate(k)``  outputs from the committed state and the inputs now; pure, may be called again.
3. ``write(k)``     a device sends its command, right after all outputs are evaluated.
4. ``step(k)``      a model commits its state over [k, k + period) with the inputs at k.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.meaning import NO_SLOT, Meaning, Slot
from cosim.base.texts import TextCells


class Causality(StrEnum):
    """How a variable is seen from outside (FMI 3.0, section 2.4.7.4)."""

    STRUCTURAL_PARAMETER = "structuralParameter"
    PARAMETER = "parameter"
    CALCULATED_PARAMETER = "calculatedParameter"
    INPUT = "input"
    OUTPUT = "output"
    LOCAL = "local"
    INDEPENDENT = "independent"


class VariableType(StrEnum):
    """The type of a variable, named as in FMI 3.0; FMI 2.0 types map onto Float64 and Int32."""

    FLOAT32 = "Float32"
    FLOAT64 = "Float64"
    INT8 = "Int8"
    UINT8 = "UInt8"
    INT16 = "Int16"
    UINT16 = "UInt16"
    INT32 = "Int32"
    UINT32 = "UInt32"
    INT64 = "Int64"
    UINT64 = "UInt64"
    BOOLEAN = "Boolean"
    ENUMERATION = "Enumeration"
    STRING = "String"
    BINARY = "Binary"

    @property
    def is_float(self) -> bool:
        """Whether a cell of this type holds a double; every other numeric type holds an int64."""
        return self in {VariableType.FLOAT32, VariableType.FLOAT64}

    @property
    def is_text(self) -> bool:
        """Whether a cell of this type holds the number of a text or of binary data."""
        return self in {VariableType.STRING, VariableType.BINARY}

    @property
    def limits(self) -> tuple[int, int] | None:
        """The least and the most of a whole number of this type, or ``None``.

        A cell has 64 bits with a sign, so the upper half of UInt64 is not there.
        """
        return _LIMITS.get(self)


_LIMITS: dict[VariableType, tuple[int, int]] = {
    VariableType.INT8: (-(2**7), 2**7 - 1),
    VariableType.UINT8: (0, 2**8 - 1),
    VariableType.INT16: (-(2**15), 2**15 - 1),
    VariableType.UINT16: (0, 2**16 - 1),
    VariableType.INT32: (-(2**31), 2**31 - 1),
    VariableType.UINT32: (0, 2**32 - 1),
    VariableType.INT64: (-(2**63), 2**63 - 1),
    VariableType.UINT64: (0, 2**63 - 1),
    VariableType.ENUMERATION: (-(2**63), 2**63 - 1),
}


class Role(StrEnum):
    """What becomes of a pantograph variable when a device takes the model's place."""

    ACTUATED = "actuated"
    MEASURED = "measured"
    DERIVED = "derived"
    SIMULATION_ONLY = "simulation_only"


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """One variable of a component.

    ``shape`` is empty for a scalar and ``(n,)`` or ``(n, m)`` for an array. ``unit`` is the FMI
    unit string, ``None`` where the variable has none. ``start`` has ``shape`` or is a scalar.
    ``meaning`` is what others look for, and ``belongs_to`` whose it is: one for all elements, or a
    tuple with one for each.
    """

    name: str
    type: VariableType = VariableType.FLOAT64
    causality: Causality
    variability: str = "continuous"
    unit: str | None = None
    start: Any = None
    shape: tuple[int, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    description: str = ""
    is_relative: bool = False
    """A difference, to which the offset of its unit does not apply (FMI ``relativeQuantity``)."""
    role: Role | None = None
    items: Mapping[str, int] | None = None
    meaning: Meaning | tuple[Meaning | None, ...] | None = None
    belongs_to: Slot | tuple[Slot, ...] = NO_SLOT

    def meaning_of(self, index: int = 0) -> Meaning | None:
        """What element ``index`` (from 0, row-major) means."""
        if not isinstance(self.meaning, tuple):
            return self.meaning
        return self.meaning[index] if index < len(self.meaning) else None

    def slot_of(self, index: int = 0) -> Slot:
        """Whose element ``index`` (from 0, row-major) is."""
        if not isinstance(self.belongs_to, tuple):
            return self.belongs_to
        return self.belongs_to[index] if index < len(self.belongs_to) else NO_SLOT


Cells = NDArray[np.float64] | NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Played:
    """Rows over time that the loop itself shows at a component's outputs.

    ``times`` (rows,) in s, rising; ``rows`` (rows, outputs), the outputs in the order of
    ``Component.variables``, all of them real scalars. Before the first row the first is shown,
    after the last the last; between two of them the one before, or with ``is_linear`` what lies on
    the line through them.
    """

    times: NDArray[np.float64]
    rows: NDArray[np.float64]
    is_linear: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What a component is told once, before its first tick.

    ``parameters`` hold the scenario's values by variable name. ``tick`` is the base tick in
    seconds as (numerator, denominator); ``period`` is the component's step in ticks; ``start_time``
    is the time of tick 0 (s).
    """

    name: str
    parameters: Mapping[str, Any]
    tick: tuple[int, int]
    period: int
    seed: int
    start_time: float = 0.0


class Component(ABC):
    """A model written in Python, or a device; it knows its variables before ``initialise``."""

    feedthrough: bool = True
    """Whether outputs may depend directly on inputs of the same tick (see ``dependencies``)."""

    @property
    @abstractmethod
    def variables(self) -> Sequence[Variable]:
        """Every variable; the same at every call."""

    @property
    def played(self) -> Played | None:
        """What is shown at the outputs in place of ``evaluate``, at no cost in a tick."""
        return None

    @property
    def files(self) -> Sequence[Path]:
        """What it has read besides its parameters: a snapshot belongs to their content, too."""
        return ()

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        """For each output, the inputs it depends on directly; an absent output depends on none."""
        return {}

    @property
    def terminals(self) -> Mapping[str, Mapping[str, str]]:
        """Bundles that connect as one: terminal -> member -> variable."""
        return {}

    @abstractmethod
    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Take parameters and keep the views: inputs to read from, outputs to write into.

        A view has the variable's shape (``(1,)`` for a scalar); floats are float64, every other
        numeric type is int64 (a boolean is 0 or 1).

        Raises:
            InputError: a parameter cannot be used.
        """

    def bind_texts(self, inputs: Mapping[str, TextCells], outputs: Mapping[str, TextCells]) -> None:
        """Keep the views of String and Binary variables; called before ``initialise``.

        A component with such inputs or outputs has to have this method of its own.
        """

    def rehearse(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """``initialise`` for a check: no first tick follows, and no device is opened.

        A component that reaches outside of its process there replaces this.

        Raises:
            InputError: a parameter cannot be used.
        """
        self.initialise(setup, inputs, outputs)

    def read(self, tick: int) -> None:
        """Take this tick's measurements into the outputs (devices)."""

    def evaluate(self, tick: int) -> None:
        """Write the outputs from the committed state and the inputs now; must be pure."""

    def write(self, tick: int) -> None:
        """Send this tick's command from the inputs (devices)."""

    def step(self, tick: int) -> None:
        """Commit the state over [tick, tick + period) using the inputs as they are now."""

    def close(self) -> None:
        """Release what was acquired; called once on every exit path, also after an error."""
