"""``cohaptic netchar``: measure the network between two machines."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import FIGURES, Number, OutputFile, seconds

if TYPE_CHECKING:
    from cosim.link.netchar.probe import Probe
    from cosim.link.netchar.statistics import Characteristics
    from cosim.link.session.keys import PreSharedKey

KEY = click.option(
    "--key",
    type=click.Path(path_type=Path),
    help="Key file of 'cohaptic keygen'; needed beyond this machine.",
)


@click.group("netchar")
def command() -> None:
    """Measure the network between two machines (the thesis's Table 1.1).

    Run 'serve' on one machine and 'probe' on the other, with the same key.
    """


@command.command("serve", cls=JsonCommand)
@click.option("--listen", default="127.0.0.1:47010", show_default=True, help="host:port to bind.")
@KEY
@click.option(
    "--max-rate",
    type=Number(0.1, 1e5),
    default=20_000.0,
    show_default=True,
    help="Packets relayed a second.",
)
@click.option(
    "--max-duration",
    type=seconds(),
    default=3600.0,
    show_default=True,
    help="Seconds a measurement.",
)
@click.option("--for", "seconds", type=seconds(zero=True), help="Stop after that many seconds.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object at the end.")
def serve_command(
    *,
    listen: str,
    key: Path | None,
    max_rate: float,
    max_duration: float,
    seconds: float | None,
    as_json: bool,
) -> None:
    """Relay the packets of 'netchar probe' back, until Ctrl-C."""
    from cosim.link.netchar.relay import Caps, Relay, serve
    from cosim.link.wire.address import Address, refuse_open_network
    from cosim.link.wire.sockets import open_socket

    address = Address.parse(listen, "--listen")
    refuse_open_network([address], has_key=key is not None)
    relay = Relay(_key(key), Caps(rate=max_rate, duration=max_duration))
    link = open_socket(address, None)
    click.echo(f"Relaying on {address}; Ctrl-C ends it.", err=True)
    end = None if seconds is None else time.monotonic() + seconds
    interrupted = _catch_interrupt()
    shown = -1

    def report() -> None:
        nonlocal shown
        for sentence in relay.notes():
            click.echo(f"\r{sentence}", err=True)
        if relay.received != shown:
            shown = relay.received
            click.echo(f"\r{shown} packets of this measurement relayed", nl=False, err=True)

    def stop() -> bool:
        return bool(interrupted) or (end is not None and time.monotonic() > end)

    try:
        serve(link, relay, stop=stop, report=report)
    finally:
        link.close()
    click.echo(err=True)
    facts = {
        "relayed": relay.received,
        "dropped": relay.dropped,
        "capped": relay.capped,
        "handshakes_failed": relay.handshakes_failed,
        "refused": relay.refused,
    }
    if as_json:
        click.echo(json.dumps(facts))
    else:
        click.echo(
            f"{relay.received} packets of the last measurement relayed; {relay.dropped} datagrams "
            f"were not authentic or stray, {relay.capped} beyond the caps; "
            f"{relay.handshakes_failed} greetings failed, {relay.refused} were told to wait."
        )


@command.command("probe", cls=JsonCommand)
@click.argument("server")
@KEY
@click.option(
    "--rate", type=Number(0.1, 1e5), default=128.0, show_default=True, help="Packets a second."
)
@click.option(
    "--duration",
    type=Number(0, 86_400, min_open=True),
    default=10.0,
    show_default=True,
    help="Seconds; the thesis: 2160.",
)
@click.option("--size", default=280, show_default=True, help="Bytes of a packet.")
@click.option("--search/--no-search", default=False, help="Find the achievable packet rate, too.")
@click.option(
    "--highest",
    type=Number(0.1, 1e5),
    default=16_384.0,
    show_default=True,
    help="Where the search ends.",
)
@click.option("--out", type=OutputFile(), help="Write the channel preset (YAML).")
@click.option("--figure", type=OutputFile(FIGURES), help="Write a figure (png, pdf, svg).")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def probe_command(
    *,
    server: str,
    key: Path | None,
    rate: float,
    duration: float,
    size: int,
    search: bool,
    highest: float,
    out: Path | None,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Send time-tagged packets to 'netchar serve' at SERVER (host:port) and say what came back."""
    from cosim.link.netchar.probe import Probe, check_measurement
    from cosim.link.netchar.statistics import characterise
    from cosim.link.wire.address import Address, refuse_open_network
    from cosim.link.wire.sockets import open_socket

    check_measurement(rate, duration, size)
    address = Address.parse(server, "SERVER")
    refuse_open_network([address], has_key=key is not None)
    any_host = "::" if ":" in address.resolve()[1][0] else "0.0.0.0"
    local = Address("127.0.0.1" if address.is_loopback and any_host != "::" else any_host, 0)
    link = open_socket(local, address)
    interrupted = _catch_interrupt()
    try:
        probe = Probe(link, _key(key))
        probe.connect()
        measurement = probe.measure(
            rate=rate,
            duration=duration,
            size=size,
            progress=_progress,
            stop=lambda: bool(interrupted),
        )
        click.echo(err=True)
        found = characterise(measurement)
        facts = found.as_dict() | {"server": str(address)}
        if search and not interrupted:
            facts["rate_search"] = _search(probe, size, rate, highest)
    finally:
        link.close()
    if out is not None:
        from cosim.link.netchar.preset import channel_preset

        with writing(out):
            out.write_text(channel_preset(found, name=str(address)), encoding="utf-8")
        facts["preset"] = str(out)
    if figure is not None:
        from cosim.link.netchar.figure import draw

        with writing(figure):
            draw(measurement, found, figure)
        facts["figure"] = str(figure)
    if as_json:
        click.echo(json.dumps(facts))
    else:
        click.echo(_table(found, facts))


def _search(probe: Probe, size: int, rate: float, highest: float) -> dict[str, Any]:
    from dataclasses import asdict

    from cosim.link.netchar.measurement import NetworkMeasurement
    from cosim.link.netchar.search import search_rate

    def run(tried: float) -> NetworkMeasurement:
        click.echo(f"\rtrying {tried:.0f} packets a second   ", nl=False, err=True)
        return probe.measure(rate=tried, duration=max(0.5, 64.0 / tried), size=size, wait=0.3)

    found = search_rate(run, lowest=rate, highest=highest)
    click.echo(err=True)
    return asdict(found)


def _table(found: Characteristics, facts: dict[str, Any]) -> str:
    lines: list[tuple[str, str]] = []
    trip = found.round_trip
    if trip is None:
        lines.append(("Packets", f"{found.sent} sent, none came back"))
    else:
        tails = ", ".join(f"{p} %: {v * 1e3:.3f}" for p, v in trip.percentiles.items())
        lines += [
            ("Average round-trip delay", f"{trip.mean * 1e3:.4f} ms"),
            ("RMS jitter", f"{trip.rms_jitter * 1e3:.4f} ms"),
            ("Percentiles (ms)", f"{tails}; worst {trip.maximum * 1e3:.3f}"),
        ]
    loss = found.loss
    lines.append(("Packet loss", f"{loss.packets} packets out of {found.sent}"))
    if loss.packets:
        lines.append(("  there, back", f"{loss.forward}, {loss.backward}"))
        bursts = ", ".join(f"{length}: {count}" for length, count in loss.bursts.items())
        lines.append(("  bursts (length: count)", bursts))
    if loss.gilbert_elliott is not None:
        fit = loss.gilbert_elliott
        chain = f"good to bad {fit.good_to_bad:.4g}, bad to good {fit.bad_to_good:.4g}"
        lines.append(("  Gilbert-Elliott", f"{chain}, loss in bad {fit.loss_bad:.3g}"))
    lines.append(("Reordered, duplicated", f"{found.reordered}, {found.duplicates}"))
    if found.forward is not None and found.backward is not None and found.relay is not None:
        lines += [
            ("One way there", _way(found.forward.mean, found.forward.rms_jitter)),
            ("One way back", _way(found.backward.mean, found.backward.rms_jitter)),
            ("  (assuming", "that the fastest packets need as long there as back)"),
            ("In the relay", _way(found.relay.mean, found.relay.rms_jitter)),
        ]
    if "rate_search" in facts:
        rate = facts["rate_search"]
        lines.append(
            (
                "Achievable packet rate",
                f"1/{rate['achievable']:.0f} s (limit: {rate['limit']})",
            )
        )
    if found.forged:
        lines.append(("Not authentic", f"{found.forged} datagrams, dropped"))
    if found.capped:
        lines.append(
            ("Kept back by the relay", f"{found.capped} packets beyond its --max-rate, not lost")
        )
    if found.late:
        lines.append(("Came too late", f"{found.late} packets, given up before; not lost"))
    if found.late_replies:
        lines.append(("Late replies", f"{found.late_replies}, to an earlier measurement's packets"))
    if found.unsent:
        lines.append(
            ("Not sent here", f"{found.unsent} packets (a full queue, no route); not lost")
        )
    if found.late_sends:
        lines.append(("Sent late here", f"{found.late_sends} packets (a busy computer)"))
    width = max(len(name) for name, _ in lines)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in lines)


def _way(mean: float, jitter: float) -> str:
    return f"{mean * 1e3:.4f} ms, jitter {jitter * 1e3:.4f} ms rms"


def _progress(sent: int, returned: int, count: int) -> None:
    click.echo(f"\r{sent} of {count} packets sent, {returned} back", nl=False, err=True)


def _key(path: Path | None) -> PreSharedKey:
    from cosim.link.session.keys import NO_KEY, read_key_file

    return NO_KEY if path is None else read_key_file(path)


def _catch_interrupt() -> list[int]:
    """A list that Ctrl-C puts something into, so that what was measured is still reported."""
    caught: list[int] = []

    def note(number: int, _frame: object) -> None:
        caught.append(number)

    signal.signal(signal.SIGINT, note)
    signal.signal(signal.SIGTERM, note)
    return caught
