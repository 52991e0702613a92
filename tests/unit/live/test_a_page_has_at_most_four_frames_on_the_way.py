"""Credit by acknowledgement: what a page has not drawn is not piled up for it."""

from __future__ import annotations

import asyncio
import json

from hypothesis import given
from hypothesis import strategies as st

from cosim.live.viewer import CREDIT, Viewer

ACTIONS = st.lists(st.sampled_from(["picture", "acknowledge", "send"]), max_size=120)


class Stage:
    """A picture that changes, and what a viewer is sent of it."""

    def __init__(self) -> None:
        self.picture = 0
        self.viewer = Viewer()

    def frame(self, viewer: Viewer) -> str:
        viewer.sent += 1
        return json.dumps([viewer.sent, self.picture])

    async def send(self) -> list[list[int]]:
        """What goes out now, without waiting for more."""
        try:
            texts = await asyncio.wait_for(self.viewer.next(self.frame), 0.001)
        except TimeoutError:
            return []
        return [json.loads(text) for text in texts]


@given(ACTIONS)
def test_no_more_than_the_credit_is_unacknowledged_and_each_frame_is_the_newest(
    actions: list[str],
) -> None:
    async def play() -> None:
        stage, acknowledged = Stage(), 0
        for action in actions:
            if action == "picture":
                stage.picture += 1
                stage.viewer.offer()
            elif action == "acknowledge":
                acknowledged = min(acknowledged + 1, stage.viewer.sent)
                stage.viewer.acknowledge(acknowledged)
            else:
                for number, picture in await stage.send():
                    assert picture == stage.picture
                    assert number - acknowledged <= CREDIT

    asyncio.run(play())


def test_a_page_that_never_acknowledges_is_sent_four_frames() -> None:
    async def play() -> int:
        stage = Stage()
        for _ in range(50):
            stage.picture += 1
            stage.viewer.offer()
            await stage.send()
        return stage.viewer.sent

    assert asyncio.run(play()) == CREDIT


def test_after_a_stall_the_next_frame_is_the_present() -> None:
    async def play() -> None:
        stage = Stage()
        for _ in range(500):
            stage.picture += 1
            stage.viewer.offer()
            await stage.send()
        stage.viewer.acknowledge(CREDIT)
        assert await stage.send() == [[CREDIT + 1, 500]]

    asyncio.run(play())


def test_an_acknowledgement_of_what_was_never_sent_gives_no_credit() -> None:
    viewer = Viewer(sent=4)
    viewer.acknowledge(1_000_000)
    assert not viewer.has_credit
