"""FMUs in event mode: the master equals FMPy's calls, one by one, bit for bit and tick by tick."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.base.errors import InputError, RunError
from cosim.base.recording import MemorySink
from cosim.cli.support.fmu.report import describe, to_text
from cosim.master.run.simulation import assemble
from cosim.testing.reference_loop import ReferenceLoop
from tests.support.fmus.clocked import CLOCKS, ByHand, clock, clocked_fmu
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of
from tests.support.master.snapshots import LateSink

TICKS = 60
PYTHON = """
from cosim.base.component import *

class Gives(Component):
    variables = tuple(
        Variable(name=n, causality=Causality.OUTPUT, type=t)
        for n, t in {"u": VariableType.FLOAT64, "uc": VariableType.FLOAT64,
                     "d": VariableType.INT32, "triggered": VariableType.INT64}.items()
    )
    def initialise(self, setup, inputs, outputs):
        self.outputs = outputs
        self.evaluate(0)
    def save(self):
        return None
    def load(self, values):
        pass
    def evaluate(self, tick):
        self.outputs["u"][0] = 1 + tick % 7
        self.outputs["uc"][0] = 0.1 * tick
        self.outputs["d"][0] = tick // 5
        self.outputs["triggered"][0] = tick // 4
"""


def values(tick: int) -> dict[str, float]:
    return {"u": 1 + tick % 7, "uc": 0.1 * tick, "d": tick // 5, "triggered": tick // 4}


def scenario(folder: Path, path: Path, more: str = "", extra: str = "") -> str:
    (folder / "gives.py").write_text(PYTHON)
    return scenario_of(
        folder,
        f"duration: {TICKS / 100}\nbase_rate: 100\ncomponents:\n"
        f"  it: {{fmu: {path}, rate: 100{more}}}\n"
        "  by: {python: 'gives:Gives', rate: 100}\n"
        "connections: [by.u -> it.u, by.uc -> it.uc, by.d -> it.d, by.triggered -> it.triggered]\n"
        + extra,
    )


TURN = "events: [{at: 0.3, set: {it.p: 5}}]\n"


@pytest.mark.parametrize("more", ["", ", isolate: process"])
def test_every_kind_of_clock(tmp_path: Path, more: str) -> None:
    path = clocked_fmu(tmp_path)
    sink = MemorySink()
    with assemble(scenario(tmp_path, path, more, TURN)) as simulation:
        simulation.run(sink)
    by_hand = ByHand(path, 0.01, TICKS)
    rows = []
    for tick in range(TICKS):
        rows.append(by_hand.outputs())
        by_hand.go(values(tick), 5 if tick == 30 else None)
    assert {row["yt"] for row in rows} != {0}
    for name in rows[0]:
        expected = np.array([row[name] for row in rows])
        assert len(set(expected)) > 1, name
        np.testing.assert_array_equal(np.asarray(sink.signal(f"it.{name}")), expected, name)


def test_times_by_counters_are_those_by_decimals(tmp_path: Path) -> None:
    variables = (
        scalar(3, "y", 1, causality="output")
        + clock("d", 10, "constant", intervalDecimal="0.02", shiftDecimal="0.04")
        + clock("e", 11, "constant", intervalCounter="1", shiftCounter="2", resolution="50")
    )
    path = foreign_fmu(tmp_path, 3, variables, interface={"hasEventMode": "true"})
    sink = MemorySink()
    text = f"duration: 0.1\nbase_rate: 100\ncomponents: {{it: {{fmu: {path}, rate: 100}}}}\n"
    with assemble(scenario_of(tmp_path, text)) as simulation:
        simulation.run(sink)
    assert sink.signal("it.d").tolist() == [0, 0, 0, 0, 1, 1, 2, 2, 3, 3]
    assert sink.signal("it.e").tolist() == sink.signal("it.d").tolist()


ANNOUNCES = """
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep"))
            m->real[1] += 1 + 100 * (m->last - m->time);
        if (is(call, "UpdateDiscreteStates"))
            m->has_next = true, m->next = m->last + 0.01125;
        return 0;
    }
    #define HOOK hook
"""
"""Each event announces the next, which lies within a step; ``y`` has how long the parts were."""


@pytest.mark.parametrize("start", [0, 10])
def test_clocks_and_announced_events_count_from_the_start(tmp_path: Path, start: int) -> None:
    """Intervals begin there, and event times are the model's."""
    variables = scalar(3, "y", 1, causality="output") + clock(
        "c", 10, "constant", intervalDecimal="0.03", shiftDecimal="0.01"
    )
    path = foreign_fmu(
        tmp_path,
        3,
        variables,
        snippet=ANNOUNCES,
        structure='<Output valueReference="1"/>',
        interface={"hasEventMode": "true"},
    )
    sink = MemorySink()
    text = (
        f"start_time: {start}\nduration: 0.2\nbase_rate: 100\n"
        f"components: {{it: {{fmu: {path}, rate: 100}}}}\n"
    )
    with assemble(scenario_of(tmp_path, text)) as simulation:
        simulation.run(sink)
    assert sink.signal("it.c").tolist() == [0] + [1 + (tick - 1) // 3 for tick in range(1, 20)]
    # 19 whole steps, each of which announced events have parted once or not.
    parts = sink.signal("it.y")[-1] - 19
    assert parts == pytest.approx(round(parts), abs=1e-6)
    assert 25 < parts < 45


def test_a_run_goes_on_from_a_snapshot_between_ticks_of_its_clocks(tmp_path: Path) -> None:
    loaded = scenario(tmp_path, clocked_fmu(tmp_path), extra=TURN)
    whole, rest = LateSink(), LateSink()
    taken = []
    with assemble(loaded) as simulation:
        simulation.run(whole, pauses={33: lambda: taken.append(simulation.snapshot())})
    with assemble(loaded) as simulation:
        simulation.restore(taken[0])
        simulation.run(rest)
    assert rest.digest(33) == whole.digest(33)


def test_a_second_run_is_the_first(tmp_path: Path) -> None:
    loaded = scenario(tmp_path, clocked_fmu(tmp_path), extra=TURN)
    sinks = [MemorySink(), MemorySink()]
    with assemble(loaded) as simulation:
        for sink in sinks:
            simulation.run(sink, keep_fmus=True)
            simulation.renew(simulation.assembly)
    first, second = ([sink.rows(i) for i in range(len(sink.groups))] for sink in sinks)
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_a_triggered_clock_is_wired_to_one_that_ticks(tmp_path: Path) -> None:
    """What another clock has counted is a number like any other, and recorded like one."""
    path = clocked_fmu(tmp_path)
    loaded = scenario_of(
        tmp_path,
        "duration: 0.3\nbase_rate: 100\ncomponents:\n"
        f"  a: {{fmu: {path}, rate: 100}}\n  b: {{fmu: {path}, rate: 100}}\n"
        "connections: [a.told -> b.triggered]\n"
        "record: [a.told, a.told.age, b.triggered, b.triggered.age]\n",
    )
    sink = MemorySink()
    with assemble(loaded) as simulation:
        simulation.run(sink)
    told, age = np.asarray(sink.signal("a.told")), np.asarray(sink.signal("b.triggered.age"))
    ticked = np.flatnonzero(np.diff(told)) + 1
    assert len(ticked) > 3
    assert (age[ticked + 1] == 1).all()  # it ticks at that time, which its next outputs tell


def test_event_mode_is_left_out_where_it_is_not_wanted(tmp_path: Path) -> None:
    path = clocked_fmu(tmp_path)
    plain = scenario_of(
        tmp_path,
        f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 100, event_mode: false}}}}\n",
    )
    with assemble(plain) as simulation:
        assert any("belong to clocks" in note for note in simulation.notes)
        simulation.run(MemorySink())
    with pytest.raises(InputError, match=r"it\.yc belongs to a clock"):
        assemble(
            scenario_of(
                tmp_path,
                f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 100, event_mode: false}}}}\n"
                "record: [it.yc]\n",
            )
        )


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (
            "rate: 40",
            (
                r":5:\d+: .*the clock periodic has an interval of 0\.02 s, .* of 0\.025 s; "
                r"write a rate of 50 Hz or a multiple of it, or 'event_mode: false'"
            ),
        ),
        ("rate: 100, start: {periodic: 3}", r":5:\d+: it\.periodic is a clock's"),
        ("rate: 50", r"it\.(fixed|changing) is to tick after 0\.0[13] s, which is no whole number"),
    ],
)
def test_what_does_not_fit_the_grid_is_refused_by_name(
    tmp_path: Path, keys: str, said: str
) -> None:
    path = clocked_fmu(tmp_path)
    text = f"duration: 1\nbase_rate: 200\ncomponents: \n  it: {{fmu: {path}, {keys}}}\n"
    with pytest.raises(InputError, match=said), assemble(scenario_of(tmp_path, text)) as simulation:
        simulation.run(MemorySink())


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (
            clock("c", 10, "constant", intervalDecimal="INF"),
            "c has the interval 'INF', which is no",
        ),
        (
            clock("c", 10, "fixed", shiftCounter="one", resolution="3"),
            "c has the shift 'one / 3', which is no time",
        ),
        (clock("c", 10, "constant"), "c is constant and has no intervalDecimal"),
        (clock("c", 10, "sometimes"), "c has the intervalVariability 'sometimes'"),
        (clock("c", 10, "fixed", causality="local"), "c is fixed, so it has to be an input"),
        (clock("c", 10, "triggered", clocks="1"), "c belongs to y, which is no clock"),
        (
            scalar(3, "u", 2, causality="input", start="0", clocks="1"),
            "u belongs to y, which is no clock",
        ),
        (
            "".join(clock(f"c{n}", n, "triggered") for n in range(100, 162)),
            "it has 63 clocks; up to 62 are driven",
        ),
    ],
)
def test_clocks_that_cannot_be_driven_are_refused_unless_left_out(
    tmp_path: Path, more: str, said: str
) -> None:
    variables = scalar(3, "y", 1, causality="output") + clock("t", 9, "triggered") + more
    path = foreign_fmu(tmp_path, 3, variables, interface={"hasEventMode": "true"})
    text = f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 10}}}}\n"
    with pytest.raises(InputError, match=rf":3:\d+: .*{said}.*'event_mode: false' leaves its"):
        assemble(scenario_of(tmp_path, text))
    assemble(scenario_of(tmp_path, text.replace("rate", "event_mode: false, rate"))).close()


@pytest.mark.parametrize("version", [2, 3])
def test_event_mode_that_is_not_there_is_refused(tmp_path: Path, version: int) -> None:
    path = foreign_fmu(tmp_path, version, scalar(version, "y", 1, causality="output"))
    text = f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 10, event_mode: true}}}}\n"
    with pytest.raises(InputError, match=r":3:\d+: it: .* has no event mode \(hasEventMode"):
        assemble(scenario_of(tmp_path, text))


def test_a_library_without_event_mode_is_refused(tmp_path: Path) -> None:
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "y", 1, causality="output"),
        snippet="#define WITHOUT_EVENTS\n",
        interface={"hasEventMode": "true"},
    )
    text = f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 10, event_mode: true}}}}\n"
    with (
        pytest.raises(
            InputError, match=r"no function fmi3EnterEventMode and none fmi3EnterStepMode"
        ),
        assemble(scenario_of(tmp_path, text)) as simulation,
    ):
        simulation.run(MemorySink())


def hooked(body: str) -> str:
    return (
        f"static int hook(Foreign *m, const char *call) {{ {body} return 0; }}\n#define HOOK hook\n"
    )


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            "m->again = m->time > 0.25;",
            "wants its discrete states updated, 1000 times over, at tick",
        ),
        (
            'if (is(call, "DoStep")) m->early = m->time > 0.25, m->last = m->time;',
            "returned from one step 1000 times over at tick 3",
        ),
        (
            'if (is(call, "DoStep")) m->early = m->time > 0.25, m->last = 9;',
            "returned early at 9 s, which is outside of its step, at tick 3",
        ),
        (
            "m->has_next = m->time > 0.25, m->next = 0.0 / 0.0;",
            "announced its next event for nan s, which is no time, at tick 3",
        ),
        (
            'if (is(call, "UpdateDiscreteStates") && m->time > 0.25) return 3;',
            "returned status 'error' in fmi3UpdateDiscreteStates at tick 3",
        ),
        (
            'm->event = m->time > 0.25; if (is(call, "EnterEventMode")) return 4;',
            "returned status 'fatal' in fmi3EnterEventMode at tick 3",
        ),
        (
            "m->interval[10] = 0.123, m->qualifier[10] = m->time > 0.25 ? 2 : 0;",
            r"it\.c is to tick after 0\.123 s, which is no whole number of the component's steps",
        ),
        (
            "m->qualifier[10] = m->time > 0.25 ? 7 : 0;",
            r"it\.c has to tell its next interval, and tells none, at tick 3",
        ),
        ("m->real[2] = 0.0 / 0.0; m->ticks[11] = m->time > 0.25;", r"it\.yc became NaN at tick 3"),
    ],
)
def test_whoever_cannot_be_followed_is_named(tmp_path: Path, body: str, said: str) -> None:
    event = 'if (is(call, "DoStep")) m->event = true;'
    variables = (
        scalar(3, "y", 1, causality="output")
        + clock("c", 10, "countdown")
        + clock("told", 11, "triggered", causality="output")
        + scalar(3, "yc", 2, causality="output", variability="discrete", clocks="11")
    )
    path = foreign_fmu(
        tmp_path,
        3,
        variables,
        snippet=hooked(event + body),
        interface={"hasEventMode": "true"},
        structure='<Output valueReference="1"/><Output valueReference="2"/>'
        '<Output valueReference="11"/>',
    )
    text = f"duration: 1\nbase_rate: 10\ncomponents: {{it: {{fmu: {path}, rate: 10}}}}\n"
    with pytest.raises(RunError, match=said), assemble(scenario_of(tmp_path, text)) as simulation:
        simulation.run(MemorySink())


TOLD = """
    static int initialising;
    static int hook(Foreign *m, const char *call)
    {{
        if (is(call, "EnterInitializationMode") || is(call, "ExitInitializationMode"))
            initialising = is(call, "EnterInitializationMode");
        return 0;
    }}
    #define HOOK hook
    EXPORT int fmi3SetIntervalDecimal(Foreign *m, const uint32_t *r, size_t n, const double *v)
    {{
        for (size_t i = 0; i < n; i++)
            m->real[1] += initialising ? 1000 * r[i] + v[i] : 1e9;
        return {status};
    }}
"""


def chosen(folder: Path, status: int, keys: str = "") -> str:
    """Clocks with an interval, of which the importer may choose two; ``y`` is what it was told."""
    path = foreign_fmu(
        folder,
        3,
        scalar(3, "y", 1, causality="output")
        + clock("constant", 10, "constant", intervalDecimal="0.2")
        + clock("fixed", 11, "fixed", intervalDecimal="0.5")
        + clock("tunable", 12, "tunable", intervalDecimal="0.25"),
        snippet=TOLD.format(status=status),
        interface={"hasEventMode": "true"},
        structure='<Output valueReference="1"/>',
    )
    text = f"duration: 1\nbase_rate: 20\ncomponents: {{it: {{fmu: {path}, rate: 20{keys}}}}}\n"
    return scenario_of(folder, text)


@pytest.mark.parametrize("keys", ["", ", isolate: process"])
def test_an_interval_that_is_ours_to_choose_is_told_at_initialisation(
    tmp_path: Path, keys: str
) -> None:
    """It is the one that the description proposes; that of a constant clock is nobody's choice."""
    sink = MemorySink()
    with assemble(chosen(tmp_path, 0, keys)) as simulation:
        simulation.run(sink)
    assert sink.signal("it.y")[0] == 11_000.5 + 12_000.25
    assert sink.signal("it.tunable")[-1] == 4


def test_an_interval_that_the_fmu_does_not_take_is_refused(tmp_path: Path) -> None:
    with (
        assemble(chosen(tmp_path, 3)) as simulation,
        pytest.raises(InputError, match="the FMU refused to take the intervals of its clocks"),
    ):
        simulation.run(MemorySink())


def test_a_triggered_clock_ticks_at_one_instant_of_an_event(tmp_path: Path) -> None:
    """In the iterations that follow at the same time it rests; many counts are one tick."""
    body = """
        static int passes;
        if (is(call, "EnterEventMode")) passes = 0;
        if (is(call, "UpdateDiscreteStates")) {
            m->whole[1] += m->ticks[10];
            m->again = passes++ < 2 && m->time > 0;
        }
    """
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "n", 1, "Int32", causality="output") + clock("c", 10, "triggered"),
        snippet=hooked(body),
        interface={"hasEventMode": "true"},
        structure='<Output valueReference="1"/>',
    )
    (tmp_path / "jumps.py").write_text(
        "from cosim.base.component import *\nclass Jumps(Component):\n"
        "    variables = (Variable(name='y', causality=Causality.OUTPUT,"
        " type=VariableType.INT64),)\n"
        "    def initialise(self, setup, inputs, outputs): self.y = outputs['y']\n"
        "    def evaluate(self, tick): self.y[0] = 3 * (tick // 2)\n"
    )
    sink = MemorySink()
    text = (
        f"duration: 0.8\nbase_rate: 10\ncomponents:\n  it: {{fmu: {path}, rate: 10}}\n"
        "  by: {python: 'jumps:Jumps', rate: 10}\nconnections: [by.y -> it.c]\n"
    )
    with assemble(scenario_of(tmp_path, text)) as simulation:
        simulation.run(sink)
    assert sink.signal("it.n").tolist() == [0, 0, 0, 1, 1, 2, 2, 3]


@pytest.mark.parametrize(("when", "kind"), [("m->time > 0.25", None), ("1", InputError)])
def test_an_update_may_ask_for_the_end(tmp_path: Path, when: str, kind: type | None) -> None:
    body = f'if (is(call, "DoStep")) m->event = true; m->terminate = {when} && !is(call, "DoStep");'
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "y", 1, causality="output"),
        snippet=hooked(body),
        interface={"hasEventMode": "true"},
    )
    text = (
        "duration: 1\nbase_rate: 10\n"
        f"components: {{it: {{fmu: {path}, rate: 10, event_mode: true}}}}\n"
    )
    with assemble(scenario_of(tmp_path, text)) as simulation:
        if kind is not None:
            with pytest.raises(kind, match="asked to end the simulation before its first tick"):
                simulation.run(MemorySink())
        else:
            assert simulation.run(MemorySink()).ended_by.startswith("it asked to end")
            assert simulation.outcome.ticks == 4


def test_a_text_is_not_carried_in_event_mode(tmp_path: Path) -> None:
    path = foreign_fmu(
        tmp_path,
        3,
        scalar(3, "s", 1, "String", '<Start value="a"/>', causality="input")
        + scalar(3, "t", 2, "String", causality="output"),
        interface={"hasEventMode": "true"},
    )
    text = (
        "duration: 1\nbase_rate: 10\ncomponents:\n"
        f"  it: {{fmu: {path}, rate: 10, event_mode: true}}\n"
        f"  by: {{fmu: {path}, rate: 10}}\nconnections: [by.t -> it.s]\n"
    )
    with pytest.raises(InputError, match=r":7:\d+: .*that is not carried in event mode"):
        assemble(scenario_of(tmp_path, text))


def test_the_reference_loop_refuses_event_mode(tmp_path: Path) -> None:
    path = clocked_fmu(tmp_path)
    text = f"duration: 1\ncomponents: {{it: {{fmu: {path}, rate: 100}}}}\n"
    with (
        assemble(scenario_of(tmp_path, text)) as simulation,
        pytest.raises(InputError, match="it is led through event mode"),
    ):
        ReferenceLoop(simulation.assembly)


def test_inspect_lists_clocks_and_what_belongs_to_them(tmp_path: Path) -> None:
    report = describe(clocked_fmu(tmp_path))
    clocks = {each["name"]: each for each in report["clocks"]}
    assert list(clocks) == list(CLOCKS)
    assert clocks["periodic"]["variables"] == ["uc", "yc"]
    assert clocks["told"]["of"] == ["periodic"]
    shown = to_text(report)
    assert "periodic  constant, input, interval 0.02 s, has uc, yc" in shown
    assert "told  triggered, output, belongs to periodic" in shown
