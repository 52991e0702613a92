"""What comes of a datagram at either side of a handshake."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.link.session.live import Keep


@dataclass(frozen=True, slots=True)
class SessionOutcome:
    """``answer`` is to be sent back; ``keep`` is a first copy under the present session."""

    answer: bytes | None = None
    keep: Keep | None = None


NOTHING = SessionOutcome()


@dataclass(slots=True)
class Drops:
    """Datagrams of a handshake that changed nothing, by why."""

    foreign: int = 0
    """Not authentic: noise, another key, another version."""
    stray: int = 0
    """Authentic, but of no question or session of now (copies, delayed ones), or senseless."""
    too_many: int = 0
    """Greetings beyond what may cost key agreements."""
    same_name: int = 0
    """Of the foreign ones, those that a station of the own name would send."""

    @property
    def total(self) -> int:
        """All of them."""
        return self.foreign + self.stray + self.too_many
