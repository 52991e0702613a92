"""What nodes say of themselves: states in heartbeats, boot-up messages, emergencies, silence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.protocol import Emergency, NmtState
from hil.wire.can_bus import CanBus


def told_under(node: int) -> tuple[int, int, int]:
    """Identifiers of what a node says and nobody may miss: heartbeats, emergencies, SDO answers."""
    return wire.heartbeat_id(node), wire.emergency_id(node), wire.sdo_answer_id(node)


@dataclass(slots=True)
class Events:
    """What came in a tick that is not as it should be."""

    lost: str | None = None
    """A node that is silent, started anew, or is not operational."""
    reports: dict[int, Emergency] = field(default_factory=dict[int, Emergency])
    """By node: the first emergency that is an error."""

    @property
    def said(self) -> str:
        """All of it in one sentence, empty for nothing."""
        reports = [f"CANopen node {node} reports {what}" for node, what in self.reports.items()]
        return "; ".join([*reports, *([self.lost] if self.lost else [])])


class Supervision:
    """Watches nodes that each send a heartbeat; time is counted in the ticks of :meth:`take`."""

    def __init__(self, nodes: tuple[int, ...], silent_ticks: int) -> None:
        self._silent_ticks = silent_ticks
        self.states = dict.fromkeys(nodes, NmtState.BOOT_UP)
        self._silence = dict.fromkeys(nodes, 0)
        self._told = [(node, wire.heartbeat_id(node), wire.emergency_id(node)) for node in nodes]

    @property
    def all_operational(self) -> bool:
        """Whether every node was, when it was last heard of."""
        return set(self.states.values()) == {NmtState.OPERATIONAL}

    def take(self, bus: CanBus) -> Events:
        """What came since the last tick.

        Raises:
            ProtocolError: a heartbeat or an emergency that cannot be one.
        """
        events = Events()
        for node, heartbeats, emergencies in self._told:
            self._hear(node, bus.received.taken(heartbeats), events)
            for data in bus.received.taken(emergencies):
                report = wire.emergency(data)
                # One that takes errors back, and whose register shows one still, does not.
                if report.code or report.register:
                    events.reports.setdefault(node, report)
        return events

    def _hear(self, node: int, heartbeats: Sequence[bytes], events: Events) -> None:
        self._silence[node] = 0 if heartbeats else self._silence[node] + 1
        for data in heartbeats:
            self.states[node] = state = wire.state(data)
            if state is NmtState.BOOT_UP:
                events.lost = events.lost or f"CANopen node {node} has started anew"
            elif state is not NmtState.OPERATIONAL:
                word = state.name.lower().replace("_", "-")
                events.lost = events.lost or f"CANopen node {node} became {word}"
        if self._silence[node] > self._silent_ticks:
            events.lost = events.lost or (
                f"the heartbeat of CANopen node {node} has been missing for "
                f"{self._silence[node]} ticks"
            )
