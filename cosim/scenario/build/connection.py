"""A written connection resolved: its ends known, its channel joining their stations."""

from __future__ import annotations

import re
from collections.abc import Mapping

from cosim.base.document.node import PathKey
from cosim.base.suggest import did_you_mean
from cosim.scenario.build.context import Context
from cosim.scenario.form.document import ConnectionForm
from cosim.scenario.model import Channel, Connection, Delay, ScenarioComponent


def build_connection(
    context: Context,
    index: int,
    form: ConnectionForm,
    components: Mapping[str, ScenarioComponent],
    channels: Mapping[str, Channel],
) -> Connection | None:
    """The connection, or ``None`` after reporting a problem (perhaps with one of its ends)."""
    path = ("connections", index)
    known = _check_ends(context, path, form)
    rate = context.rate(form.rate, path) if form.rate is not None else None
    if form.via is not None and form.via not in context.names("channels"):
        if not context.is_whole("channels"):
            return None
        hint = did_you_mean(form.via, context.names("channels"))
        context.problems.add((*path, "via"), f"there is no channel '{form.via}'.{hint}")
        return None
    if form.target.component in context.names("channels"):
        turned = channels.get(form.target.component)
        return None if turned is None else _to_channel(context, path, form, turned, components)
    source, target = components.get(form.source.component), components.get(form.target.component)
    is_about = form.source.component not in context.names("components")
    about = channels.get(form.source.component) if is_about else None
    if not known or target is None or (source is None and about is None):
        return None
    if about is not None:
        joined = _check_about(context, path, form, about, target)
    else:
        assert source is not None
        ends = (source.station, target.station)
        joined = _check_stations(context, path, form, ends, channels)
    if form.via is not None and form.delay is not None:
        message = f"the delay is the channel's; give it to channels.{form.via}."
        context.problems.add((*path, "delay"), message)
    if not joined or rate in context.refused or (form.rate is not None and rate is None):
        return None
    period = context.timebase.period(rate) if rate is not None else None
    owner = source or about
    assert owner is not None
    delay = Delay()
    if form.delay is not None:
        delay = context.timebase.delay(form.delay, period or owner.period)
    return Connection(
        source=form.source,
        target=form.target,
        via=form.via,
        rate=rate,
        period=period,
        delay=delay,
        initial=form.initial,
        ignores_unit=form.unit == "ignore",
        factor=form.factor,
        offset=form.offset,
    )


def check_signal(context: Context, path: tuple[PathKey, ...], name: str) -> None:
    """Report a pattern whose first part matches no component and no channel."""
    known = {*context.names("components"), *context.names("channels")}
    if name in known or not (context.is_whole("components") and context.is_whole("channels")):
        return
    wild = re.compile(re.escape(name).replace(r"\*", ".*").replace(r"\?", "."))
    if not any(wild.fullmatch(other) for other in known):
        hint = did_you_mean(name, known)
        context.problems.add(path, f"there is no component '{name}'.{hint}", at_key=True)


def _check_ends(context: Context, path: tuple[PathKey, ...], form: ConnectionForm) -> bool:
    """Whether both ends name something."""
    components, channels = context.names("components"), context.names("channels")
    is_known = True
    for key, end, sections in (
        ("from", form.source, (components, channels)),
        ("to", form.target, (components, channels)),
    ):
        if not any(end.component in section for section in sections):
            is_known = False
            if not (context.is_whole("components") and context.is_whole("channels")):
                continue
            hint = did_you_mean(end.component, [name for names in sections for name in names])
            message = f"there is no component '{end.component}' ({_text(form)}).{hint}"
            context.problems.add((*path, key), message)
    return is_known


def _check_stations(
    context: Context,
    path: tuple[PathKey, ...],
    form: ConnectionForm,
    ends: tuple[str, str],
    channels: Mapping[str, Channel],
) -> bool:
    """Whether the channel, or its absence, fits the stations of both ends."""
    here, there = ends
    if here == there:
        if form.via is not None:
            message = f"{_text(form)} stays inside the station {here}; leave 'via' out."
            context.problems.add((*path, "via"), message)
        return form.via is None
    joining = [name for name, channel in channels.items() if {here, there} == {*channel.between}]
    if form.via in joining:
        return True
    if form.via is not None:
        if form.via not in channels:
            return False  # reported with the channel
        others = " and ".join(channels[form.via].between)
        message = f"{_text(form)} goes from {here} to {there}, but {form.via} joins {others}."
    else:
        message = f"{_text(form)} goes from the station {here} to {there} without a channel"
        message += f"; add 'via {joining[0]}'." if joining else ", and none joins them."
    context.problems.add((*path, "via"), message)
    return False


def _to_channel(
    context: Context,
    path: tuple[PathKey, ...],
    form: ConnectionForm,
    channel: Channel,
    components: Mapping[str, ScenarioComponent],
) -> Connection | None:
    """A connection that turns a channel's delay, jitter or loss."""
    source = components.get(form.source.component)
    if source is None:
        if form.source.component in context.names("channels"):
            message = f"{_text(form)}: what turns a channel is an output of a component."
            context.problems.add((*path, "from"), message)
        return None
    if source.station not in channel.between:
        message = (
            f"{_text(form)} goes from the station {source.station}, which is no end of "
            f"{channel.name}; it joins {' and '.join(channel.between)}."
        )
        context.problems.add((*path, "from"), message)
    for key in ("via", "rate", "delay"):
        if getattr(form, key) is not None:
            message = f"{_text(form)} turns a channel; leave '{key}' out."
            context.problems.add((*path, key), message)
    if form.initial != "source":
        message = f"{_text(form)} turns a channel, which has no 'start'; leave 'initial' out."
        context.problems.add((*path, "initial"), message)
    return Connection(source=form.source, target=form.target)


def _check_about(
    context: Context,
    path: tuple[PathKey, ...],
    form: ConnectionForm,
    channel: Channel,
    target: ScenarioComponent,
) -> bool:
    """Whether what a channel says about its packets is used where they arrive."""
    direction = form.source.path.partition(".")[0]
    receivers = {"forward": channel.between[1], "backward": channel.between[0]}
    if direction not in receivers:
        message = f"write {channel.name}.forward.… or {channel.name}.backward.…"
        context.problems.add((*path, "from"), message)
        return False
    if target.station != receivers[direction]:
        message = (
            f"{form.source} is known in the station {receivers[direction]}, where the packets "
            f"arrive; {form.target} is in {target.station}."
        )
        context.problems.add((*path, "from"), message)
        return False
    return True


def _text(form: ConnectionForm) -> str:
    return f"{form.source} -> {form.target}"
