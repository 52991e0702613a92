"""An operation as it is written: the kernel's structure, and what belongs to it outside of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import VariableType
from cosim.master.kernel.codes import OperationKind
from cosim.master.kernel.structures import OperationStruct


@dataclass(frozen=True, slots=True)
class Call:
    """A call-out to a Python component, or to ``forward`` or ``backward`` of a turned channel.

    Or what passes the texts of an FMU, and returns the status, or records those of a group.
    """

    component: str
    method: str
    is_channel: bool = False
    passes: Callable[[], int] | None = None
    records: Callable[[int], None] | None = None


class Accessor(NamedTuple):
    """The function of an FMU that an operation calls: that which sets or gets a type."""

    component: str
    kind: VariableType
    is_set: bool


class WrittenOperation(NamedTuple):
    """An operation, with the memory that it points to."""

    operation: OperationStruct
    memory: tuple[Any, ...] = ()
    call: Call | None = None
    accessor: Accessor | None = None


def with_table(kind: OperationKind, rows: Sequence[Any], *, owner: int = 0) -> WrittenOperation:
    """An operation on a table of whole numbers, one row an element."""
    table: NDArray[np.int32] = np.array(rows, dtype=np.int32)
    operation = OperationStruct(
        kind=kind, owner=owner, cell_count=len(rows), table=table.ctypes.data
    )
    return WrittenOperation(operation, (table,))
