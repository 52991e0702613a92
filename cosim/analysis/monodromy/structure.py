"""Which numbers a number moves, and which can be moved in one run because nothing is moved twice.

A number that is moved leaves what does not depend on it the same to the last bit, so that the zeros
of a derivative made one column at a time are exact. Columns without a common row are then as well
told apart when all are moved at once (Curtis, Powell and Reid 1974): the rows say whose they are.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cosim.theory.numerics import Bool, Real

NOBODY = -1
"""The owner of a row that a group does not move."""


class MapStructure:
    """The structure of a derivative.

    Args:
        moved: shape (n, n), whether the row's number follows the column's.
    """

    def __init__(self, moved: Bool) -> None:
        self.moved = moved

    @classmethod
    def of(cls, matrix: Real) -> MapStructure:
        """That of a derivative whose zeros are exact."""
        return cls(np.asarray(matrix != 0.0))

    def widened(self, first: int) -> MapStructure:
        """The same where nothing is known of the columns from ``first`` on."""
        moved = self.moved.copy()
        moved[:, first:] = True
        return MapStructure(moved)

    @cached_property
    def groups(self) -> tuple[tuple[NDArray[np.int64], NDArray[np.int64]], ...]:
        """Columns to be moved together, and for every row the one of them that it follows."""
        found: list[tuple[list[int], NDArray[np.int64]]] = []
        for column in map(int, np.argsort(-self.moved.sum(axis=0), kind="stable")):
            rows = self.moved[:, column]
            for columns, owners in found:
                if (owners[rows] == NOBODY).all():
                    columns.append(column)
                    owners[rows] = column
                    break
            else:
                found.append(([column], np.where(rows, column, NOBODY)))
        return tuple((np.array(columns), owners) for columns, owners in found)
