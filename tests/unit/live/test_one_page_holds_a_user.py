"""Seats: a user is held by one page at a time, and who is free does as the others do."""

from __future__ import annotations

import pytest

from cosim.live.control import PlayControl
from cosim.live.mailbox import Mailbox
from cosim.live.seats import Seats
from cosim.live.viewer import Viewer

SCENE = {
    "pointers": [
        {"station": "a", "fingers": [{"reach": [0.0, 0.0, 0.1]}, {"reach": [0.1, 0.0, 0.1]}]},
        {"station": "b", "fingers": [{"reach": [0.0, -0.5, 0.1]}, {"reach": [0.1, -0.5, 0.1]}]},
    ]
}
HAND = [1000.0, 0.01, 0.02, 0.09, 0.02]


@pytest.fixture
def table():
    boxes = {"a": Mailbox.create(), "b": Mailbox.create()}
    control = PlayControl.create()
    seats = Seats(boxes, control)
    seats.follow(SCENE)
    yield seats, boxes, control
    for each in (*boxes.values(), control):
        each.remove()


def test_the_second_page_is_the_second_user_and_the_third_looks_on(table):
    seats, _, _ = table
    pages = [Viewer() for _ in range(3)]
    for page in pages:
        seats.seat(page)
    assert [page.user for page in pages] == ["a", "b", None]
    assert not seats.hear(pages[2], {"user": "a"}), "a is taken"
    seats.leave(pages[0])
    assert seats.hear(pages[2], {"user": "a"})
    assert [page.user for page in pages] == [None, "b", "a"]


def test_a_hand_goes_to_its_own_user_alone_where_both_are_taken(table):
    seats, boxes, _ = table
    one, other = Viewer(), Viewer()
    seats.seat(one)
    seats.seat(other)
    seats.hear(one, {"hand": HAND})
    assert boxes["a"].newest()[1:] == [1.0, *HAND[1:]]
    assert boxes["b"].newest() is None


def test_who_is_free_does_the_same_in_their_own_place(table):
    seats, boxes, _ = table
    page = Viewer()
    seats.seat(page)
    seats.hear(page, {"hand": HAND})
    assert boxes["b"].newest()[2:] == pytest.approx([0.01, -0.48, 0.09, -0.48])


def test_a_page_that_leaves_is_said_to_have_gone(table):
    seats, boxes, _ = table
    page = Viewer()
    seats.seat(page)
    seats.hear(page, {"hand": HAND})
    seats.leave(page)
    assert boxes["a"].newest()[1] == 0.0


@pytest.mark.parametrize(
    "hand",
    [
        None,
        [],
        HAND[:4],
        [*HAND, 0.0],
        [*HAND[:4], "0"],
        [*HAND[:4], None],
        [*HAND[:4], True],
        [*HAND[:4], float("nan")],
        [*HAND[:4], 1e9],
        {"x": 1},
    ],
)
def test_a_hand_that_is_none_is_dropped(table, hand):
    seats, boxes, _ = table
    page = Viewer()
    seats.seat(page)
    seats.hear(page, {"hand": hand})
    assert boxes["a"].newest() is None


def test_who_looks_on_moves_and_controls_nothing(table):
    seats, boxes, control = table
    pages = [Viewer() for _ in range(3)]
    for page in pages:
        seats.seat(page)
    before = control.changes
    seats.hear(pages[2], {"hand": HAND, "control": {"restart": True}})
    assert boxes["a"].newest() is None
    assert control.changes == before


@pytest.mark.parametrize(
    "wish", [{"speed": 7}, {"speed": "1"}, {"paused": 1}, {"step": 1}, {"restart": "yes"}, [], None]
)
def test_a_wish_that_is_none_changes_nothing(table, wish):
    _, _, control = table
    before = control.changes
    assert not control.hear(wish)
    assert control.changes == before


def test_wishes_are_seen_by_the_loop(table):
    _, _, control = table
    loop = PlayControl.attach(control.path)
    for wish in ({"paused": True}, {"step": True}, {"speed": 0.25}, {"restart": True}):
        assert control.hear(wish)
    loop.look()
    assert (loop.paused, loop.steps, loop.speed, loop.restarts) == (True, 1, 0.25, 1)
