"""People's hands in a scenario that a command was given: laid over it, and read again."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean

if TYPE_CHECKING:
    from cosim.live.hands import User
    from cosim.scenario import Scenario


def laid_over(
    scenario: str,
    overlays: Sequence[str],
    documents: Mapping[str, Mapping[str, Any]],
    sets: tuple[str, ...],
) -> Scenario:
    """The scenario with some documents over its overlays; a document's name stands in errors.

    Raises:
        InputError: it cannot be read.
    """
    from cosim.reading import load

    with tempfile.TemporaryDirectory() as folder:
        files: list[Path] = []
        for name, content in documents.items():
            files.append(Path(folder) / f"{name}.yaml")
            files[-1].write_text(json.dumps(content), encoding="utf-8")
        return load(scenario, (*overlays, *files), sets)


def with_station_hands(
    scenario: str, overlays: tuple[str, ...], sets: tuple[str, ...], own: str
) -> tuple[User, Scenario]:
    """Who can be played at a station, and the scenario with pointers of all users in it.

    Every station lays the same over it, so that the records of all can be merged and run again.

    Raises:
        InputError: it cannot be read, or nobody can be played at that station.
    """
    from cosim.live.hands import users_of, with_hands
    from cosim.reading import load

    emulated = load(scenario, overlays, sets)
    users = users_of(emulated)
    found = next((user for user in users if user.station == own), None)
    if found is None:
        names = [user.station for user in users]
        raise InputError(
            f"--play: nobody can take part at {own}: none of its components is an 'operator', "
            f"whose place a hand could take.{did_you_mean(own, names)}"
        )
    return found, laid_over(scenario, overlays, {"hands": with_hands(emulated, users)}, sets)
