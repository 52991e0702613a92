"""What one station of a scenario runs, and what goes to and comes from each other station."""

from __future__ import annotations

from dataclasses import dataclass, field

from cosim.base.errors import InputError
from cosim.link.stream.bundle import PacketBundle
from cosim.link.stream.form import LinkForm
from cosim.scenario import Scenario


@dataclass(slots=True)
class Peer:
    """What goes to and comes from one other station; lists are in the order of the streams."""

    name: str
    component: str
    """Name of the remote-station component that stands for it."""
    sends: list[PacketBundle] = field(default_factory=list[PacketBundle])
    receives: list[PacketBundle] = field(default_factory=list[PacketBundle])
    settings: list[LinkForm] = field(default_factory=list[LinkForm])
    """One for each incoming stream."""
    clock: str = ""
    """Whether the two stations' ticks are held together; all channels between them say the same."""
    said_by: str = ""
    """The channel that said so first."""
    adds: bool = False
    """Whether simulated impairments come on top; all channels say the same of that, too."""

    def agree(self, channel: str, settings: LinkForm) -> None:
        """Take what all channels to this peer have to say alike.

        Raises:
            InputError: another channel says something else.
        """
        clock, adds = settings.clock, settings.add_impairments
        if not self.clock:
            self.clock, self.adds, self.said_by = clock, adds, channel
        texts = [
            (f"clock: {self.clock}", f"clock: {clock}"),
            tuple(f"add_impairments: {str(said).lower()}" for said in (self.adds, adds)),
        ]
        for first, second in texts:
            if first != second:
                message = (
                    f"the channels {self.said_by} and {channel} both lead to {self.name}, and one "
                    f"says {first}, the other {second}. Two stations have one link between them; "
                    "say the same under link: of both"
                )
                raise InputError(message)


@dataclass(frozen=True, slots=True)
class Half:
    """One station's part: a scenario in which every other station is one component."""

    own: str
    scenario: Scenario
    peers: tuple[Peer, ...]
    dropped: tuple[str, ...]
    """Connections and records that only make sense where all stations run together."""
