"""A measurement as a channel of a scenario, to ``include`` there."""

from __future__ import annotations

from math import sqrt

from cosim.link.netchar.statistics import Characteristics, Distribution


def channel_preset(found: Characteristics, *, name: str) -> str:
    """YAML of a channel's delay, jitter and loss; forward is from the probing side.

    The simulated jitter is a delay added to the base, uniform, with the measured standard
    deviation; so the base is the measured mean less that distribution's mean.
    """
    lines = [
        f"# Measured by 'cohaptic netchar probe' against {name}: {found.sent} packets of",
        f"# {found.size} bytes at {found.rate:g} a second. Use it in a scenario:",
        "#   channels:",
        "#     lan: {include: this_file.yaml, between: [a, b], rate: network}",
        "# Forward is from the side that probed; the unseen constant asymmetry is split evenly.",
    ]
    forward, backward = found.forward, found.backward
    if forward is None or backward is None:
        return "\n".join([*lines, "# No packet came back.", "loss: 1.0", ""])
    delays = [_base(side) for side in (forward, backward)]
    lines.append(f"delay: {{forward: {_ms(delays[0])}, backward: {_ms(delays[1])}}}")
    lines.append("jitter:")
    for side, way in (("forward", forward), ("backward", backward)):
        lines.append(f"  {side}: {{rms: {_ms(way.rms_jitter)}}}")
    loss = found.loss
    bursts = loss.gilbert_elliott
    if bursts is not None:
        lines.append("# Bursts as fitted to the round trip, half of them for each way.")
        lines.append(
            f"loss: {{good_to_bad: {bursts.good_to_bad / 2.0:.4g}, "
            f"bad_to_good: {bursts.bad_to_good:.4g}, loss_bad: {bursts.loss_bad:.4g}}}"
        )
    else:
        there = loss.forward / max(1, found.sent)
        back = loss.backward / max(1, found.sent - loss.forward)
        lines.append(f"loss: {{forward: {there:.6g}, backward: {back:.6g}}}")
    if found.reordered:
        lines.append(f"reorder: {found.reordered / found.sent / 2.0:.4g}")
    return "\n".join([*lines, ""])


def _base(way: Distribution) -> float:
    return max(0.0, way.mean - sqrt(3.0) * way.rms_jitter)


def _ms(seconds: float) -> str:
    return f"{max(0.0, seconds) * 1e3:.4f} ms"
