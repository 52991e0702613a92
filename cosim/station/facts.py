"""What a station's manifest says of its links; never a key."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from cosim.link.session.client import HandshakeProcess
from cosim.link.stream.fate import Fate
from cosim.link.stream.peer import Reason
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.station.half import Peer


def link_facts(
    own: str,
    grid: Grid,
    peers: Sequence[Peer],
    remotes: Sequence[RemoteStation],
    process: HandshakeProcess,
) -> dict[str, Any]:
    """Of every peer and stream what arrived, what became of it, and how long the way was."""
    found: dict[str, Any] = {
        "station": own,
        "first_tick": grid.first_tick,
        "epoch": grid.epoch,
        "sessions": process.sessions,
        "handshake_process": {
            "dropped": process.dropped,
            "absurd": process.absurd,
            "answered": bool(process.facts),
            **process.facts,
        },
        "peers": {},
    }
    for peer, remote in zip(peers, remotes, strict=True):
        link, clock = remote.link, remote.link.clock
        transport = link.transport
        found["peers"][peer.name] = {
            "component": peer.component,
            "sessions": [f"{number:016x}" for number in link.used],
            "sent": link.outgoing.sent,
            "withheld": sum(content.withheld for content in link.outgoing.contents),
            "refused": getattr(transport, "refused", 0),
            "unsent": getattr(transport, "unsent", 0),
            "foreign": link.foreign,
            "flood": link.intake.flood,
            "faulty": link.faulty,
            "before_start": link.before_start,
            "absurd_exchanges": clock.refused,
            "dropped_by_kernel": getattr(transport, "dropped_by_kernel", 0),
            "clock_offset": clock.offset(time.monotonic_ns()) if clock.ready else None,
            "clock_skew": clock.skew if clock.ready else None,
            "slew_limited": 0 if remote.follower is None else remote.follower.saturated,
            "round_trip": clock.round_trip if clock.ready else None,
            "streams": {
                item.receiver.bundle.channel: {
                    **{fate.name.lower(): int(item.receiver.counts[fate]) for fate in Fate},
                    "withheld": item.receiver.content.withheld,
                    "overdue": item.receiver.overdue,
                    "overdue_by_network": item.overdue_by_network,
                    "losses": item.weight.losses,
                    "lost_because": {
                        reason.name.lower(): count
                        for reason, count in zip(Reason, item.weight.causes, strict=True)
                        if count
                    },
                    "last_reason": item.weight.reason.name.lower(),
                    "delay": item.receiver.settings.delay,
                    "late_after": item.receiver.settings.late_after,
                }
                for item in link.incoming
            },
        }
    return found
