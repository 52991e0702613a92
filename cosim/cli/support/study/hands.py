"""The hands of participants who move them on the study's page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Self

from cosim.base.errors import InputError
from cosim.cli.support.hands import laid_over

if TYPE_CHECKING:
    from cosim.base.component import Component
    from cosim.live.mailbox import Mailbox
    from cosim.scenario import Scenario


class ParticipantHands:
    """A mailbox for each user of the conditions' scenarios; a context manager."""

    def __init__(self) -> None:
        self._boxes: dict[str, Mailbox] = {}
        self._pointers: dict[str, dict[str, str]] = {}

    @property
    def mailboxes(self) -> Mapping[str, Path]:
        """By user, where pages leave what their pointers do."""
        return {user: box.path for user, box in self._boxes.items()}

    def taken_over(self, emulated: Scenario, file: Path, sets: tuple[str, ...]) -> Scenario:
        """A condition's scenario with pointers in the place of what its operators are to do.

        Raises:
            InputError: none of its users can be played, or others than those of the conditions
                before: a page that is open already could not become them.
        """
        from cosim.live.hands import users_of, with_hands
        from cosim.live.mailbox import Mailbox

        users = users_of(emulated)
        stations = [user.station for user in users]
        if self._boxes and stations != list(self._boxes):
            raise InputError(
                f"--hands: {emulated.name} has the users {', '.join(stations)}, and another "
                f"condition has {', '.join(self._boxes)}; give all conditions the same users."
            )
        for station in stations:
            if station not in self._boxes:
                self._boxes[station] = Mailbox.create()
        self._pointers[emulated.name] = {user.pointer: user.station for user in users}
        return laid_over(str(file), (), {"hands": with_hands(emulated, users)}, sets)

    def instances(self, scenario: Scenario) -> Mapping[str, Component]:
        """The pointers of one run."""
        from cosim.live.pointer import Pointer

        pointers = self._pointers.get(scenario.name, {})
        return {name: Pointer(self._boxes[user]) for name, user in pointers.items()}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for box in self._boxes.values():
            box.remove()
        self._boxes.clear()
