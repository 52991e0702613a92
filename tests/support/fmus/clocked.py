"""An FMU of FMI 3 with a clock of every kind, and the standard's loop over FMPy's own calls."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tests.support.fmus.foreign import foreign_fmu, scalar

INTERFACE = {
    "hasEventMode": "true",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "mightReturnEarlyFromDoStep": "true",
}
U, D, UC, Y, YC, N, P, YT = 1, 2, 3, 4, 5, 6, 7, 8
PERIODIC, FIXED, TUNABLE, CHANGING, COUNTDOWN, TRIGGERED, TOLD = range(10, 17)
CLOCKS = {
    "periodic": PERIODIC,
    "fixed": FIXED,
    "tunable": TUNABLE,
    "changing": CHANGING,
    "countdown": COUNTDOWN,
    "triggered": TRIGGERED,
    "told": TOLD,
}

SNIPPET = """
    static double h = 0.01;
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "Instantiate"))
            m->whole[7] = 4;
        if (is(call, "EnterInitializationMode")) {
            m->interval[11] = 3 * h, m->qualifier[11] = 2, m->shift[11] = h;
            m->interval[12] = m->whole[7] * h, m->qualifier[12] = 2;
            m->interval[13] = h, m->qualifier[13] = 2;
        }
        if (is(call, "GetClock"))
            m->ticks[16] = m->ticks[10] && m->whole[20] % 3 == 2;
        if (is(call, "UpdateDiscreteStates")) {
            m->qualifier[12] = m->interval[12] != m->whole[7] * h ? 2 : 1;
            m->interval[12] = m->whole[7] * h;
            m->qualifier[14] = 0;
            if (m->ticks[10]) {
                m->whole[20]++;
                if (m->whole[20] % 4 == 0)
                    m->interval[14] = 3 * h, m->qualifier[14] = 2;
            }
            if (m->ticks[13])
                m->interval[13] = (1 + m->whole[21]++ % 3) * h;
            if (m->ticks[14])
                m->whole[22]++;
            if (m->real[4] > 1)
                m->real[4] -= 1, m->whole[6] += 100;
            if (m->whole[2] != m->whole[23])
                m->whole[23] = m->whole[2], m->whole[6]++;
            m->has_next = true;
            m->next = 0.075; /* one that lies within a step */
        }
        if (is(call, "GetFloat64") && m->ticks[10])
            m->real[5] = 2 * m->real[3] + m->whole[20];
        if (is(call, "GetInt32") && m->ticks[15])
            m->whole[8] = 10 * m->whole[2] + m->whole[20];
        if (is(call, "DoStep")) {
            double length = m->last - m->time;
            double y = m->real[4] + 20 * m->real[1] * length;
            if (m->real[4] <= 1 && y > 1 && m->early_allowed) {
                double part = (1 - m->real[4]) / (20 * m->real[1]) * (1 + 1e-9);
                m->last = m->time + part;
                m->early = part < length;
                y = m->real[4] + 20 * m->real[1] * part;
            }
            m->real[4] = y;
            m->event = y > 1;
        }
        return 0;
    }
    #define HOOK hook

    static Foreign kept[8];
    static int keeps;
    static void move(char *to, const char *from)
    {
        for (size_t i = 0; i < sizeof(Foreign); i++)
            to[i] = from[i];
    }
    EXPORT int fmi3GetFMUState(Foreign *m, void **state)
    {
        Foreign *place = *state ? *state : &kept[keeps++ % 8];
        move((char *)place, (const char *)m);
        *state = place;
        return 0;
    }
    EXPORT int fmi3SetFMUState(Foreign *m, void *state)
    {
        Foreign now = *m;
        move((char *)m, state);
        m->log3 = now.log3, m->environment = now.environment, m->resources = now.resources;
        return 0;
    }
    EXPORT int fmi3FreeFMUState(Foreign *m, void **state) { *state = 0; return 0; }
    EXPORT int fmi3SerializedFMUStateSize(Foreign *m, void *state, size_t *size)
    {
        *size = sizeof(Foreign);
        return 0;
    }
    EXPORT int fmi3SerializeFMUState(Foreign *m, void *state, char *bytes, size_t size)
    {
        move(bytes, state);
        return 0;
    }
    EXPORT int fmi3DeserializeFMUState(Foreign *m, const char *bytes, size_t size, void **state)
    {
        *state = &kept[keeps++ % 8];
        move(*state, bytes);
        return 0;
    }
"""
# FMPy wants every function of the standard to be there.
_OTHERS = """
    ActivateModelPartition CompletedIntegratorStep EnterContinuousTimeMode EvaluateDiscreteStates
    GetAdjointDerivative GetContinuousStateDerivatives GetContinuousStates GetDirectionalDerivative
    GetEventIndicators GetIntervalFraction GetNominalsOfContinuousStates GetNumberOfEventIndicators
    GetNumberOfContinuousStates GetNumberOfVariableDependencies GetOutputDerivatives SetTime
    GetShiftFraction GetVariableDependencies InstantiateModelExchange SetIntervalDecimal
    InstantiateScheduledExecution SetContinuousStates SetIntervalFraction SetShiftDecimal
    SetShiftFraction
"""
SNIPPET += "\n".join(f"EXPORT int fmi3{name}(void) {{ return 3; }}" for name in _OTHERS.split())


def clock(name: str, reference: int, variability: str, **more: str) -> str:
    """One clock."""
    causality = more.pop("causality", "input")
    return (
        f'<Clock name="{name}" valueReference="{reference}" causality="{causality}" '
        f'intervalVariability="{variability}" {" ".join(f"{k}={v!r}" for k, v in more.items())}/>'
    )


def clocked_fmu(
    folder: Path, *, snippet: str = SNIPPET, interval: str = "0.02", **more: Any
) -> Path:
    """The FMU; ``interval`` is that of its constant clock (s)."""
    variables = "\n".join(
        (
            scalar(3, "u", U, causality="input", start="0"),
            scalar(3, "d", D, "Int32", causality="input", start="0"),
            scalar(3, "uc", UC, causality="input", start="0", variability="discrete", clocks="10"),
            scalar(3, "y", Y, causality="output"),
            scalar(3, "yc", YC, causality="output", variability="discrete", clocks="10"),
            scalar(3, "n", N, "Int32", causality="output"),
            scalar(3, "p", P, "Int32", causality="parameter", variability="tunable", start="4"),
            scalar(3, "yt", YT, "Int32", causality="output", clocks="15"),
            clock("periodic", PERIODIC, "constant", intervalDecimal=interval),
            clock("fixed", FIXED, "fixed"),
            clock("tunable", TUNABLE, "tunable"),
            clock("changing", CHANGING, "changing"),
            clock("countdown", COUNTDOWN, "countdown"),
            clock("triggered", TRIGGERED, "triggered"),
            clock("told", TOLD, "triggered", causality="output", clocks="10"),
        )
    )
    structure = "".join(
        f'<Output valueReference="{each}" dependencies=""/>' for each in (Y, YC, N, YT, TOLD)
    )
    interface = INTERFACE | more.pop("interface", {})
    return foreign_fmu(
        folder, 3, variables, snippet=snippet, structure=structure, interface=interface, **more
    )


class ByHand:
    """One instance over FMPy, led through event mode as FMI 3.0, section 4.2, says."""

    def __init__(self, path: Path, step: float, ticks: int) -> None:
        import fmpy
        from fmpy.fmi3 import FMU3Slave

        description = fmpy.read_model_description(path, validate=False)
        self.fmu: Any = FMU3Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path, tempfile.mkdtemp()),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="it",
        )
        self.step = step
        self.index = 0
        self.next: float | None = None
        self.due: dict[str, int] = {"periodic": 0}
        self.length: dict[str, int] = {"periodic": 2}
        self.count = dict.fromkeys(CLOCKS, 0)
        self.last = dict.fromkeys(CLOCKS, -1)
        self.yc = self.uc = 0.0
        self.yt = self.triggers = self.d = 0
        fmu = self.fmu
        fmu.instantiate(eventModeUsed=True, earlyReturnAllowed=True)
        fmu.setInt32([P], [4])
        fmu.enterInitializationMode(startTime=0.0, stopTime=step * ticks)
        for name in ("fixed", "tunable", "changing"):
            interval, _ = self.interval(name)
            self.length[name] = round(interval / step)
        shifts = {name: self.shift(name) for name in ("fixed", "tunable")}
        self.due |= {name: round(shift / step) for name, shift in shifts.items()}
        self.due["changing"] = self.length["changing"]
        fmu.exitInitializationMode()
        self.instants(set(), 0.0)
        fmu.enterStepMode()

    def interval(self, name: str) -> tuple[float, int]:
        from ctypes import c_double, c_int, c_uint32

        reference, value, how = (c_uint32 * 1)(CLOCKS[name]), (c_double * 1)(), (c_int * 1)()
        self.fmu.fmi3GetIntervalDecimal(self.fmu.component, reference, 1, value, how)
        return value[0], how[0]

    def shift(self, name: str) -> float:
        from ctypes import c_double, c_uint32

        reference, value = (c_uint32 * 1)(CLOCKS[name]), (c_double * 1)()
        self.fmu.fmi3GetShiftDecimal(self.fmu.component, reference, 1, value)
        return value[0]

    def instants(self, active: set[str], beyond: float) -> None:
        """Everything at one time, in event mode."""
        fmu = self.fmu
        active = active | {
            name for name, due in self.due.items() if due == self.index and not beyond
        }
        while True:
            for name in active:
                fmu.setClock([CLOCKS[name]], [True])
                if name in {"periodic", "fixed", "tunable"}:
                    self.due[name] += self.length[name]
                else:
                    self.due.pop(name, None)
            if "periodic" in active:
                fmu.setFloat64([UC], [self.uc])
                if fmu.getClock([TOLD])[0]:
                    active.add("told")
            for name in active:
                self.count[name] += 1
                self.last[name] = self.index + (beyond > 0)
            if "periodic" in active:
                self.yc = fmu.getFloat64([YC])[0]
            if "triggered" in active:
                self.yt = fmu.getInt32([YT])[0]
            again, _, _, _, has_next, next_time = fmu.updateDiscreteStates()
            self.next = next_time if has_next else None
            interval, how = self.interval("tunable")
            if how == 2:
                self.length["tunable"] = round(interval / self.step)
                self.due["tunable"] = self.index + round((beyond + interval) / self.step)
            if "changing" in active:
                self.due["changing"] = self.index + round(self.interval("changing")[0] / self.step)
            interval, how = self.interval("countdown")
            if how == 2:
                self.due["countdown"] = self.index + round((beyond + interval) / self.step)
            if not again:
                return
            active = set()

    def event(self, active: set[str], beyond: float = 0.0) -> None:
        self.fmu.enterEventMode()
        if self.d_wanted != self.d:
            self.d = self.d_wanted
            self.fmu.setInt32([D], [self.d])
        self.instants(active, beyond)
        self.fmu.enterStepMode()

    def outputs(self) -> dict[str, float]:
        """What is read before a step."""
        fmu = self.fmu
        row = {"y": fmu.getFloat64([Y])[0], "n": fmu.getInt32([N])[0], "yc": self.yc, "yt": self.yt}
        for name in CLOCKS:
            if name != "triggered":
                row[name] = self.count[name]
            row[f"{name}.age"] = -1 if self.last[name] < 0 else self.index - self.last[name]
        return row

    def go(self, values: Mapping[str, float], turned: int | None = None) -> None:
        """One step with these inputs."""
        fmu, self.uc, self.d_wanted = self.fmu, values["uc"], int(values["d"])
        fmu.setFloat64([U], [values["u"]])
        if turned is not None:
            fmu.setInt32([P], [turned])
        triggers = int(values["triggered"])
        active = {"triggered"} if triggers != self.triggers else set[str]()
        if active or turned is not None or self.d_wanted != self.d:
            self.event(active)
        self.triggers = triggers
        begin, end = self.index * 1.0 / 100.0, (self.index + 1) * 1.0 / 100.0
        at, margin = begin, 1e-9 * self.step
        while True:
            to = end
            if self.next is not None and at + margin < self.next < end - margin:
                to = self.next
            length = self.step if (at, to) == (begin, end) else to - at
            event, _, early, last = fmu.doStep(at, length)
            at = last if early else to
            event = event or (self.next is not None and self.next <= at + margin)
            if at >= end - margin:
                break
            if event:
                self.event(set(), at - begin)
        self.index += 1
        if event or self.index in self.due.values():
            self.event(set())
