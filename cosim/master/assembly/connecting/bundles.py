"""What connections have carried for them, and by what: packets of a channel, samples of a rate."""

from __future__ import annotations

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.master.assembly.connecting.ends import Pair
from cosim.master.assembly.knobs import Knobs
from cosim.master.assembly.wiring import Bundle, Entry, Held, PacketFact
from cosim.master.channels.fates import Fates, fates_of
from cosim.scenario import Connection, Direction, Scenario

_AGE = {"age": "ticks since the held packet was sampled", "sequence": "number of the held packet"}


class Bundles:
    """The bundles of a wiring; everything with the same channel, way and rate shares one."""

    def __init__(self, scenario: Scenario, knobs: Knobs, bundles: list[Bundle]) -> None:
        """``bundles`` is filled."""
        self._scenario = scenario
        self._knobs = knobs
        self._all = bundles
        self._numbers: dict[tuple[str, str, int], int] = {}

    def of(self, connection: Connection) -> int | None:
        """The number of the bundle that a connection goes through, if it goes through one.

        Raises:
            InputError: it crosses stations without a channel, or its channel joins others.
        """
        if connection.target.component in self._scenario.channels:
            return None
        components = self._scenario.components
        there = components.get(connection.source.component)
        here = components[connection.target.component]
        if connection.via is None:
            if there is not None and there.station != here.station:
                raise InputError(
                    f"{connection} goes from station {there.station} to station {here.station} "
                    "without a channel; add 'via' and the channel's name"
                )
            return self._sampler(connection)
        channel = self._scenario.channels.get(connection.via)
        if channel is None:
            hint = did_you_mean(connection.via, self._scenario.channels)
            raise InputError(f"there is no channel '{connection.via}'.{hint}")
        if there is None:
            raise InputError(f"{connection}: what a channel says about packets stays where it is")
        ends = (there.station, here.station)
        if ends not in {channel.between, channel.between[::-1]}:
            raise InputError(
                f"{connection}: channel {channel.name} joins {' and '.join(channel.between)}, not "
                f"{ends[0]} and {ends[1]}"
            )
        way = "forward" if ends == channel.between else "backward"
        period = connection.period or channel.period
        key = (channel.name, way, period)
        if key not in self._numbers:
            rate = self._scenario.base_rate / period
            fates = fates_of(
                self._scenario.seed,
                channel.name,
                way,
                rate,
                channel.direction(*ends),
                extremes=self._knobs.extremes(channel.name, way),
            )
            name = f"{channel.name}.{way}"
            if period != channel.period:
                name += f" at {float(rate):g} Hz"
            self._numbers[key] = self._add(Bundle(name, channel.name, way, period, fates))
        return self._numbers[key]

    def _sampler(self, connection: Connection) -> int | None:
        if connection.period is None and connection.delay.ticks == 0:
            return None
        source = self._scenario.components.get(connection.source.component)
        own = source.period if source is not None else 1
        period = connection.period or own
        fates = Fates(direction=Direction(delay=connection.delay), key=0)
        return self._add(Bundle(str(connection), None, "", period, fates))

    def _add(self, bundle: Bundle) -> int:
        self._all.append(bundle)
        return len(self._all) - 1

    def enter(self, bundle: int, connection: Connection, pair: Pair) -> Held:
        """Have a bundle carry the source of a pair, too."""
        start = pair.target if connection.initial == "start" else None
        entries = self._all[bundle].entries
        entries.append(Entry(pair.source, pair.source_variable.type.is_float, start))
        return Held(bundle, len(entries) - 1)

    def packet_fact(self, channel: str, path: str) -> PacketFact:
        """``forward.age`` and the like of a channel.

        Raises:
            InputError: there is no such signal, or nothing is sent that way.
        """
        way, _, name = path.partition(".")
        if way not in {"forward", "backward"} or name not in _AGE:
            known = [f"{way}.{name}" for way in ("forward", "backward") for name in _AGE]
            raise InputError(
                f"channel {channel} has no signal '{path}'.{did_you_mean(path, known)}"
            )
        period = self._scenario.channels[channel].period
        bundle = self._numbers.get((channel, way, period))
        if bundle is None:
            raise InputError(
                f"nothing is sent {way} through channel {channel}, so it has no {name}"
            )
        return PacketFact(bundle, name)
