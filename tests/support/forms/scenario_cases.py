"""For each key of a scenario, two documents that differ in that key alone."""

from __future__ import annotations

from typing import Any

from tests.support.forms.walk import Key

PARTS = "tests.support.forms.parts"
BASE: dict[str, Any] = {
    "cohaptic": 1,
    "duration": 0.08,
    "seed": 1,
    "rates": {"fast": 1000, "slow": 500},
    "components": {
        "a": {"python": f"{PARTS}:Ramp", "station": "s", "rate": "fast"},
        "b": {"python": f"{PARTS}:Follow", "station": "t", "rate": "fast"},
    },
    "channels": {"lan": {"between": ["s", "t"], "rate": "slow", "each_way_delay": 1}},
    "connections": [{"from": "a.x", "to": "b.u", "via": "lan"}],
}
BACK = {"connections": [*BASE["connections"], {"from": "b.y", "to": "c.u", "via": "lan"}]}
"""Something crosses the other way, too."""
THREE = {
    "components": {"c": {"python": f"{PARTS}:Follow", "station": "s", "rate": "fast"}},
    **BACK,
}
GONE = None
"""Takes a member of the base away."""


def document(*overlays: dict[str, Any]) -> dict[str, Any]:
    """The base with overlays over it; ``None`` takes a member away."""
    made: dict[str, Any] = BASE
    for over in overlays:
        made = _over(made, over)
    return made


def _over(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    made = dict(base)
    for key, value in over.items():
        if value is None:
            made.pop(key, None)
        elif isinstance(value, dict) and isinstance(made.get(key), dict):
            made[key] = _over(made[key], value)
        else:
            made[key] = value
    return made


def lan(**keys: Any) -> dict[str, Any]:
    """Over the channel, whose delay goes where another key gives one."""
    own_delay = {"delay", "round_trip_delay", "trace", "each_way_delay"} & keys.keys()
    return {"channels": {"lan": {**({"each_way_delay": None} if own_delay else {}), **keys}}}


def part(name: str, **keys: Any) -> dict[str, Any]:
    """Over a component."""
    return {"components": {name: keys}}


def joined(**keys: Any) -> dict[str, Any]:
    """The only connection, inside one station."""
    connection = {"from": "a.x", "to": "b.u", **keys}
    return {"components": {"b": {"station": "s"}}, "channels": None, "connections": [connection]}


def turned(to: dict[str, Any], at: float = 0.01) -> dict[str, Any]:
    """What is turned, and when."""
    return {"events": [{"at": at, "set": to}]}


FMU = {
    "components": {"a": None, "b": None, "f": {"fmu": "operator", "rate": "fast"}},
    "channels": None,
    "connections": None,
}


def fmu(**keys: Any) -> dict[str, Any]:
    """One bundled FMU instead of everything."""
    made = {**FMU["components"]["f"], **keys}
    return {**FMU, "components": {**FMU["components"], "f": made}}


LOOP = {
    "components": {
        "a": None,
        "b": None,
        "c": {"fmu": "virtual_coupler", "rate": "fast"},
        "s": {"fmu": "signal", "rate": "fast", "parameters": {"amplitude": 1, "frequency": 40}},
    },
    "channels": None,
    "connections": [{"from": "s.value", "to": "c.position_a"}],
}
BURSTS = {"good_to_bad": 0.3, "bad_to_good": 0.3, "loss_good": 0.1, "loss_bad": 0.8}

CASES: dict[Key, tuple[dict[str, Any], dict[str, Any], dict[str, Any]]] = {
    ("Document", "name"): ({}, {"name": "one"}, {"name": "two"}),
    ("Document", "duration"): ({}, {}, {"duration": 0.04}),
    ("Document", "start_time"): (
        {},
        fmu(fmu="signal", parameters={"mode": "sine", "frequency": 40}),
        {**fmu(fmu="signal", parameters={"mode": "sine", "frequency": 40}), "start_time": 0.03},
    ),
    ("Document", "seed"): (lan(loss=0.4), {}, {"seed": 2}),
    ("Document", "base_rate"): ({}, {}, {"base_rate": 2000}),
    ("Document", "rates"): ({}, {}, {"rates": {"slow": 250}}),
    ("Document", "components"): ({}, {}, part("d", python=f"{PARTS}:Ramp", rate="fast")),
    ("Document", "channels"): ({}, lan(each_way_delay=1), lan(each_way_delay=3)),
    ("Document", "connections"): ({}, {}, {"connections": []}),
    ("Document", "record"): ({}, {}, {"record": ["b.y"]}),
    ("Document", "events"): ({}, {}, turned({"lan.delay": 3})),
    ("EventForm", "at"): ({}, turned({"lan.delay": 3}), turned({"lan.delay": 3}, at=0.04)),
    ("EventForm", "set"): ({}, turned({"lan.delay": 3}), turned({"lan.loss": 1})),
    ("Document", "knobs"): ({}, {}, {"knobs": {"lan.delay": {"maximum": 3}}}),
    ("KnobForm", "minimum"): (
        {},
        {"knobs": {"lan.delay": {"minimum": 0, "maximum": 3}}},
        {"knobs": {"lan.delay": {"minimum": 1, "maximum": 3}}},
    ),
    ("KnobForm", "maximum"): (
        {
            **part("a", parameters={"gain": 2e-5}),  # 2 ms to 3.6 ms
            "connections": [*BASE["connections"], "a.x -> lan.forward.delay"],
        },
        {"knobs": {"lan.forward.delay": {"maximum": "3 ms"}}},
        {"knobs": {"lan.forward.delay": {"maximum": "4 ms"}}},
    ),
    ("Document", "expect"): ({}, {}, {"expect": {"b.y": {"max_below": 1}}}),
    ("ComponentForm", "python"): ({}, {}, part("b", python=f"{PARTS}:Twice")),
    ("ComponentForm", "rate"): ({}, {}, part("a", rate="slow")),
    ("ComponentForm", "station"): (
        lan(delay={"forward": 1, "backward": 4}),
        {},
        {"components": {"a": {"station": "t"}, "b": {"station": "s"}}},
    ),
    ("ComponentForm", "parameters"): ({}, {}, part("a", parameters={"gain": 2})),
    ("ComponentForm", "start"): (
        {"connections": [{**BASE["connections"][0], "initial": "start"}]},
        {},
        part("b", start={"u": 7}),
    ),
    ("ComponentForm", "fmu"): ({}, fmu(), fmu(fmu="signal")),
    ("ComponentForm", "flavour"): ({}, fmu(flavour="fmi3"), fmu(flavour="fmi2")),
    ("ComponentForm", "substeps"): (
        {},
        fmu(fmu="object", start={"force": [1.0] + 16 * [0.0]}),
        fmu(fmu="object", start={"force": [1.0] + 16 * [0.0]}, substeps=4),
    ),
    ("ComponentForm", "feedthrough"): (LOOP, {}, part("c", feedthrough=False)),
    ("ComponentForm", "device"): (
        {"channels": None, "connections": None},
        part("a", python=None, device="mock://"),
        part("a", python=None, device="haply:///dev/none"),
    ),
    ("DeviceForm", "url"): (
        {"channels": None, "connections": None},
        part("a", python=None, device={"url": "mock://"}),
        part("a", python=None, device={"url": "cobs:///dev/none"}),
    ),
    ("ConnectionForm", "from"): (
        THREE,
        {},
        {"connections": [{"from": "c.y", "to": "b.u", "via": "lan"}]},
    ),
    ("ConnectionForm", "to"): (
        {"components": {"d": {"python": f"{PARTS}:Follow", "station": "t", "rate": "fast"}}},
        {},
        {"connections": [{"from": "a.x", "to": "d.u", "via": "lan"}]},
    ),
    ("ConnectionForm", "via"): (
        {"channels": {"wan": {"between": ["s", "t"], "rate": "slow", "each_way_delay": 5}}},
        {},
        {"connections": [{"from": "a.x", "to": "b.u", "via": "wan"}]},
    ),
    ("ConnectionForm", "rate"): ({}, joined(), joined(rate="slow")),
    ("ConnectionForm", "delay"): ({}, joined(), joined(delay=3)),
    ("ConnectionForm", "factor"): ({}, joined(), joined(factor=2.5)),
    ("ConnectionForm", "offset"): ({}, joined(), joined(offset=0.125)),
    ("ConnectionForm", "initial"): (
        lan(each_way_delay=4),
        {},
        {"connections": [{**BASE["connections"][0], "initial": "start"}]},
    ),
    ("RecordForm", "signals"): (
        {},
        {"record": [{"signals": "a.x"}]},
        {"record": [{"signals": "b.y"}]},
    ),
    ("RecordForm", "rate"): (
        {},
        {"record": [{"signals": "a.x"}]},
        {"record": [{"signals": "a.x", "rate": 500}]},
    ),
    ("ChannelForm", "between"): (
        lan(each_way_delay=None, delay={"forward": 1, "backward": 4}),
        {},
        {"channels": {"lan": {"between": ["t", "s"]}}},
    ),
    ("ChannelForm", "rate"): ({}, {}, lan(rate="fast")),
    ("ChannelForm", "each_way_delay"): ({}, {}, lan(each_way_delay=2)),
    ("ChannelForm", "round_trip_delay"): ({}, lan(round_trip_delay=2), lan(round_trip_delay=6)),
    ("ChannelForm", "delay"): (
        {},
        lan(delay={"forward": 1, "backward": 1}),
        lan(delay={"forward": 3, "backward": 1}),
    ),
    ("ChannelForm", "jitter"): ({}, {}, lan(jitter=3)),
    ("ChannelForm", "loss"): ({}, {}, lan(loss=0.5)),
    ("ChannelForm", "reorder"): ({}, {}, lan(reorder=0.5)),
    ("ChannelForm", "duplication"): ({}, {}, lan(duplication=0.5)),
    ("ChannelForm", "trace"): ({}, lan(trace=[1, 2, "lost"]), lan(trace=[3, 1])),
    ("DelayBoth", "forward"): (
        {},
        lan(delay={"forward": 1, "backward": 1}),
        lan(delay={"forward": 2, "backward": 1}),
    ),
    ("DelayBoth", "backward"): (
        THREE,
        lan(delay={"forward": 1, "backward": 1}),
        lan(delay={"forward": 1, "backward": 4}),
    ),
    ("RmsJitter", "rms"): ({}, lan(jitter={"rms": "1 ms"}), lan(jitter={"rms": "6 ms"})),
    ("WeightedJitter", "weights"): (
        {},
        lan(jitter={"weights": [0.5, 0.5]}),
        lan(jitter={"weights": [0.1, 0.2, 0.7]}),
    ),
    ("WeightedJitter", "step"): (
        {},
        lan(jitter={"weights": [0.5, 0.5]}),
        lan(jitter={"weights": [0.5, 0.5], "step": 3}),
    ),
    ("LateForm", "probability"): (
        {},
        lan(reorder={"probability": 0.1, "by": 3}),
        lan(reorder={"probability": 0.9, "by": 3}),
    ),
    ("LateForm", "by"): (
        {},
        lan(reorder={"probability": 0.5, "by": 1}),
        lan(reorder={"probability": 0.5, "by": 4}),
    ),
    **{
        ("GilbertElliottForm", key): ({}, lan(loss=BURSTS), lan(loss={**BURSTS, key: value}))
        for key, value in {
            "good_to_bad": 0.9,
            "bad_to_good": 0.05,
            "loss_good": 0.6,
            "loss_bad": 0.2,
        }.items()
    },
    **{
        (f"Both{name.capitalize()}", way): (
            THREE,
            lan(**{name: {"forward": one, "backward": one}}),
            lan(**{name: {"forward": one, "backward": one, way: two}}),
        )
        for name, one, two in (
            ("jitter", 1, 6),
            ("loss", 0.1, 0.7),
            ("reorder", 0.1, 0.9),
            ("duplication", 0.1, 0.9),
            ("trace", [1], [5, "lost"]),
        )
        for way in ("forward", "backward")
    },
}
