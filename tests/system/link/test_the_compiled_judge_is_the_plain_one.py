"""What the C routine admits, and what it leaves behind, is what NumPy does, bit for bit."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.link.stream.admission import Admission, Plausibility
from cosim.link.stream.bundle import Field, PacketBundle
from cosim.station.admission import CompiledAdmission
from tests.support.link.support import PERIOD, TICK

FIELDS = (
    Field(name="position", minimum=-1.0, maximum=1.0, speed=3.0),
    Field(name="free"),
    Field(name="count", integer=True),
    Field(name="small", integer=True, minimum=0.0, maximum=255.0),
    Field(name="flag", integer=True, boolean=True, minimum=0.0, maximum=1.0),
    Field(name="pair", size=2, minimum=-10.0, maximum=10.0, speed=100.0),
)
BUNDLE = PacketBundle(source="a", target="b", fields=FIELDS, period=PERIOD, tick=TICK)
ANY = st.floats(width=64) | st.sampled_from([0.0, -0.0, 0.5, 1.0, 2.0**53, -(2.0**53), 2.0**53 + 2])
NEAR = st.floats(-1.0, 1.0)
PLAUSIBLE = st.tuples(NEAR, NEAR, *[st.integers(0, 1).map(float)] * 3, NEAR, NEAR)
PACKET = st.tuples(*[ANY] * 7) | PLAUSIBLE


@settings(deadline=None, max_examples=400)
@given(
    packets=st.lists(
        st.tuples(PACKET, st.integers(0, 2000) | st.integers(0, 2**53), st.booleans()),
        min_size=1,
        max_size=6,
    )
)
def test_both_say_the_same_and_leave_the_same_behind(packets) -> None:
    plain, compiled = Admission(BUNDLE), CompiledAdmission(BUNDLE)
    outs = np.full(BUNDLE.size, 7.0), np.full(BUNDLE.size, 7.0)
    for content, ticks, newest in packets:
        values = np.array(content)
        with np.errstate(all="ignore"):
            wanted = plain.judge(values, ticks, outs[0], newest=newest)
            assert compiled.judge(values, ticks, outs[1], newest=newest) is wanted
            assert compiled.in_range(values) == plain.in_range(values)
        assert outs[0].tobytes() == outs[1].tobytes()


def test_all_three_verdicts_occur() -> None:
    for made in (Admission, CompiledAdmission):
        judge, out = made(BUNDLE), np.zeros(BUNDLE.size)
        good = np.zeros(BUNDLE.size)
        assert judge.judge(good, 0, out, newest=True) is Plausibility.FITS
        far, bad = good.copy(), good.copy()
        far[0] = bad[2] = 0.5
        assert judge.judge(far, 8, out, newest=True) is Plausibility.JUMP
        assert judge.judge(bad, 8, out, newest=True) is Plausibility.OUT_OF_RANGE
        assert not out.any()


def test_arrays_that_come_and_go_are_not_taken_for_each_other() -> None:
    judge = CompiledAdmission(BUNDLE)
    for number in range(1000):
        values, out = np.full(BUNDLE.size, float(number % 2)), np.zeros(BUNDLE.size)
        assert judge.judge(values, 0, out, newest=False) is Plausibility.FITS
        assert out.tobytes() == values.tobytes()
        assert len(judge._addresses) <= 64
