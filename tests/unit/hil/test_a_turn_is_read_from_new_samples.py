"""A joint that is turned while its board is silent for a while has turned all the same."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hil.device.errors import DeviceError
from hil.setup.calibrate.directions import directions


class Board:
    """A device that answers nothing new for some reads after each turn."""

    def __init__(self, silent: int, drop: int = 10) -> None:
        self.angle, self.seen, self.age = [0.0, 0.0], [0.0, 0.0], 0
        self.silent, self.left, self.drop = silent, 0, drop
        self.driver = SimpleNamespace(pause=lambda: None)
        self.file = SimpleNamespace(joints=[SimpleNamespace(direction=1)] * 2)

    def read(self, _: int) -> SimpleNamespace:
        if self.left:
            self.left, self.age = self.left - 1, self.age + 1
        else:
            self.seen, self.age = list(self.angle), 0
        return SimpleNamespace(joint_angle=tuple(self.seen), sample_age=self.age)

    def write(self, *_: object) -> None: ...

    def raise_fault(self) -> None:
        if self.age >= self.drop:
            raise DeviceError("silent")


class Hand:
    def __init__(self, board: Board, by: float) -> None:
        self.board, self.by = board, by

    def leave(self, joint: int) -> None: ...

    def turn(self, joint: int) -> None:
        self.board.angle[joint] += self.by
        self.board.left = self.board.silent

    def let_go(self) -> None: ...


@pytest.mark.parametrize("silent", [0, 1, 8, 9])
@pytest.mark.parametrize(("by", "sign"), [(0.4, 1), (-0.4, -1)])
def test_the_sign_is_that_of_the_turn(silent, by, sign):
    board = Board(silent)
    assert directions(board, Hand(board, by)) == (sign, sign)


def test_a_board_that_stays_silent_is_said_to_be():
    board = Board(silent=1000)
    with pytest.raises(DeviceError, match="silent"):
        directions(board, Hand(board, 0.4))


def test_a_joint_that_did_not_turn_is_none():
    board = Board(silent=3)
    with pytest.raises(DeviceError, match=r"turned by 0\.050 rad only"):
        directions(board, Hand(board, 0.05))
