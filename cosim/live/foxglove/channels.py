"""What a run that goes on offers: its scene, and the rows of each record group."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator

import numpy as np

from cosim.base.foxglove.entities import TOPIC, SceneUpdates
from cosim.base.foxglove.rows import CDR_LITTLE_ENDIAN, RowMessage
from cosim.base.foxglove.schema import NAME, scene_schema
from cosim.live.followed import Followed
from cosim.live.foxglove.protocol import Topic

Said = tuple[int, int, bytes]
"""Topic, model time (ns), and content."""

_numbers = itertools.count(1)


class Offer:
    """The channels of one run; every viewer has had rows up to a place of its own (``seen``)."""

    def __init__(self, run: Followed) -> None:
        self._run = run
        self._rows = {
            next(_numbers): (place, RowMessage.of(name, signals, floats))
            for place, (name, signals, floats) in enumerate(run.groups())
        }
        self._scene = next(_numbers) if run.scene_signals else None

    @property
    def channels(self) -> list[Topic]:
        """All of them, the scene first."""
        found = [
            Topic(
                number=number,
                topic=message.topic,
                encoding="cdr",
                schema_name=message.schema_name,
                schema=message.definition,
                schema_encoding="ros2msg",
            )
            for number, (_, message) in self._rows.items()
        ]
        if self._scene is not None:
            scene = Topic(
                number=self._scene,
                topic=TOPIC,
                encoding="json",
                schema_name=NAME,
                schema=scene_schema().decode(),
                schema_encoding="jsonschema",
            )
            found.insert(0, scene)
        return found

    @property
    def now(self) -> int:
        """Model time of the newest row (ns)."""
        return round(self._run.time * 1e9)

    def updates(self) -> SceneUpdates:
        """What one viewer sees of the scene."""
        return SceneUpdates(self._run.scene)

    def scene(self, updates: SceneUpdates) -> Iterator[Said]:
        """The scene as it is."""
        if self._scene is None:
            return
        now = self.now
        message = updates.message(self._run.at(), now)
        if message is not None:
            yield self._scene, now, json.dumps(message, separators=(",", ":")).encode()

    def rows(self, wanted: set[int], seen: dict[int, int]) -> Iterator[Said]:
        """Rows that this viewer has not had of the channels that it wants; ``seen`` is moved on."""
        for number, (place, _) in self._rows.items():
            first, period, cells = self._run.rows_since(place, seen)
            if number not in wanted:
                continue
            ticks = (first + np.arange(len(cells))) * period
            times = self._run.start + ticks / self._run.rate
            for tick, time, row in zip(ticks.tolist(), times, cells, strict=True):
                head = np.int64(tick).tobytes() + time.tobytes()
                yield number, round(float(time) * 1e9), CDR_LITTLE_ENDIAN + head + row.tobytes()
