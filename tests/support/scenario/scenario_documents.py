"""Hypothesis strategies for whole scenario documents, as plain data."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

RATES = {"control": 1024, "network": 128, "display": "1024/32 Hz", "third": "1024/3 Hz"}
PROBABILITY = st.floats(0.0, 1.0) | st.sampled_from(["0 %", "12.5 %", "100 %"])
LAG = st.integers(0, 5) | st.sampled_from(["3 ticks", "1 tick", "2.44 ms", "0 s", "2 samples"])
LOSS = PROBABILITY | st.fixed_dictionaries(
    {"good_to_bad": st.floats(0.01, 1.0), "bad_to_good": st.floats(0.01, 1.0)},
    optional={"loss_good": PROBABILITY, "loss_bad": PROBABILITY},
)
JITTER = (
    LAG
    | st.fixed_dictionaries({"rms": st.sampled_from(["0.49 ms", "0 s", "3 ms"])})
    | st.fixed_dictionaries(
        {
            "weights": st.lists(st.floats(0.01, 1.0), min_size=1, max_size=4).map(
                lambda given: [weight / sum(given) for weight in given]
            )
        },
        optional={"step": st.sampled_from([1, "1 tick", "2 ms"])},
    )
)
LATE = PROBABILITY | st.fixed_dictionaries({"probability": PROBABILITY}, optional={"by": LAG})
VALUE = (
    st.floats(allow_nan=False, allow_infinity=False)
    | st.integers(-(2**53), 2**53)
    | st.booleans()
    | st.text(max_size=8)
    | st.lists(st.floats(-1e9, 1e9), max_size=3)
)
VARIABLE = st.sampled_from(["base_x", "finger_1.mass", "mode", "motor_torque[1]", "odd name"])


def each_or_both(kind: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return kind | st.fixed_dictionaries({"forward": kind, "backward": kind})


DELAYS = (
    st.just({})
    | st.fixed_dictionaries({"round_trip_delay": LAG})
    | st.fixed_dictionaries({"each_way_delay": LAG})
    | st.fixed_dictionaries({"delay": st.fixed_dictionaries({"forward": LAG, "backward": LAG})})
)
IMPAIRMENTS = st.fixed_dictionaries(
    {},
    optional={
        "jitter": each_or_both(JITTER),
        "loss": each_or_both(LOSS),
        "reorder": each_or_both(LATE),
        "duplication": each_or_both(LATE),
    },
)
TRACE = st.lists(LAG | st.just("lost"), min_size=1, max_size=4)
FATES = st.tuples(DELAYS, IMPAIRMENTS).map(lambda parts: {**parts[0], **parts[1]}) | (
    st.fixed_dictionaries({"trace": each_or_both(TRACE)})
)


@st.composite
def components(draw: st.DrawFn) -> dict[str, Any]:
    return draw(
        st.fixed_dictionaries(
            {
                "rate": st.sampled_from([*RATES, 512, "256 Hz"]),
                **draw(
                    st.sampled_from(
                        [
                            {"fmu": st.just("pantograph")},
                            {"fmu": st.just("operator"), "flavour": st.just("fmi2")},
                            {"fmu": st.just("pantograph"), "substeps": st.integers(1, 9)},
                            {"python": st.just("package.module:Class")},
                            {"device": st.just("mock://")},
                            {"device": st.just({"url": "haply:///dev/x", "serial": 7})},
                            {"playback": st.just("."), "of": st.just("other")},
                            {
                                "table": st.just(__file__),
                                "interpolate": st.just("linear"),
                                "time_offset": st.just("-2 s"),
                                "columns": st.just(["x"]),
                            },
                        ]
                    )
                ),
            },
            optional={
                "parameters": st.dictionaries(VARIABLE, VALUE, max_size=3),
                "start": st.dictionaries(VARIABLE, VALUE, max_size=2),
            },
        )
    )


@st.composite
def documents(draw: st.DrawFn) -> dict[str, Any]:
    """A valid document: two stations, a channel between them, connections inside and across."""
    names = draw(st.lists(st.sampled_from("pqrstu"), min_size=2, max_size=4, unique=True))
    parts = {name: {**draw(components()), "station": "ab"[i % 2]} for i, name in enumerate(names)}
    channel = {"between": ["a", "b"], "rate": "network", **draw(FATES)}
    connections: list[Any] = []
    for number in range(draw(st.integers(0, 4))):
        source, target = draw(st.sampled_from(names)), draw(st.sampled_from(names))
        entry: dict[str, Any] = {"from": f"{source}.out", "to": f"{target}.in_{number}"}
        if parts[source]["station"] != parts[target]["station"]:
            entry["via"] = "lan"
        elif draw(st.booleans()):
            entry["delay"] = draw(LAG)
        if draw(st.booleans()):
            entry["rate"] = draw(st.sampled_from(["network", 512]))
        if draw(st.booleans()):
            entry["initial"] = draw(st.sampled_from(["source", "start"]))
        connections.append(entry)
    return {
        "cohaptic": 1,
        "title": draw(st.text(max_size=20)),
        "description": draw(st.text(max_size=20)),
        "duration": draw(st.sampled_from([1, 0.1, "1/3 s", "250 ms", "2 min", 1e-3])),
        "seed": draw(st.integers(0, 2**63 - 1)),
        "rates": RATES,
        "base_rate": 1024,
        "components": parts,
        "channels": {"lan": channel},
        "connections": connections,
        "record": draw(st.sampled_from([[], ["*"], [{"signals": f"{names[0]}.x", "rate": 32}]])),
        "expect": {f"{names[0]}.x": {"max_below": draw(st.floats(0, 1))}},
        "realtime": draw(st.dictionaries(st.text(min_size=1, max_size=3), VALUE, max_size=2)),
    }
