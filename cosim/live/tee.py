"""A run without a pace, watched: its rows go into rings, too."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from fractions import Fraction

from cosim.base.recording import RecordGroup, Rows, Sink
from cosim.master.run.execution.loop import Progress
from cosim.master.run.simulation import Simulation
from cosim.realtime.live import Feed
from cosim.realtime.relay import make_rings
from cosim.realtime.ring import Ring


class TeeSink:
    """Hands rows on to the recorder, and the same rows to the rings."""

    def __init__(self, sink: Sink, rings: Sequence[Ring]) -> None:
        self._sink, self._rings = sink, rings
        self._rows: dict[int, Rows] = {}

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Told once, before the first row."""
        self._sink.begin(groups, base_rate)

    def buffer(self, group: int, rows: int) -> Rows:
        """The recorder's own room."""
        self._rows[group] = self._sink.buffer(group, rows)
        return self._rows[group]

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        """Copy what was filled, and hand it on."""
        self._rings[group].extend(self._rows[group][:rows])
        self._sink.commit(group, first_tick, rows)

    def put_text(self, group: int, column: int, tick: int, content: bytes) -> None:
        """Hand a text on; rings have numbers alone."""
        self._sink.put_text(group, column, tick, content)


def run_watched(
    simulation: Simulation, recorder: Sink, progress: Progress | None, *, starter: int
) -> None:
    """Run as fast as it goes, with the rows in rings for who looks on.

    ``starter`` is the process that was asked for the run: it can be looked for by that number, too.
    """
    from cosim.scene import describe_scene

    scenario, groups = simulation.scenario, simulation.groups
    start = float(scenario.start_time)
    with ExitStack() as stack:
        rings = make_rings(groups, scenario.base_rate)
        for ring in rings:
            stack.callback(ring.remove)
        feed = Feed(scenario.name, float(scenario.base_rate), {}, rings, start=start)
        stack.callback(feed.remove)
        scene = describe_scene(simulation.assembly, groups)
        feed.publish(groups, None, {"scene": scene, "starter": starter})
        simulation.run(TeeSink(recorder, rings), progress=progress, keep_fmus=True)
