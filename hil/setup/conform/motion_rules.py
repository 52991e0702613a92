"""Rules on what is measured, and on a switch on the board; its output stage stays off."""

from __future__ import annotations

from math import pi

from hil.setup.calibrate.turner import Turner
from hil.setup.conform.bench import EXCHANGES, ConformBench, idle
from hil.setup.conform.errors import NotConform, NotTried
from hil.setup.conform.rule import ConformRule
from hil.setup.look import newest_angles

HAND = 0.3
"""A person turns a joint by an angle that is right within this share."""


def _angles_have_sign_and_scale(bench: ConformBench) -> None:
    turner: Turner = bench.turner
    with bench.opened() as device:
        for joint in (0, 1):
            turner.leave(joint)
            before = newest_angles(device)
            turner.turn(joint)
            after = newest_angles(device)
            turner.let_go()
            moved = [after[axis] - before[axis] for axis in (0, 1)]
            exact = bench.control is not None
            allowed = 2 * device.file.quantum if exact else HAND * turner.angle
            if abs(moved[joint] - turner.angle) > allowed:
                raise NotConform(
                    f"joint {joint + 1} was turned by {turner.angle:.3f} rad counterclockwise, and "
                    f"{moved[joint]:.3f} rad were measured: direction or counts_per_turn is wrong"
                )
            if exact and abs(moved[1 - joint]) > allowed:
                raise NotConform(f"joint {2 - joint} moved as joint {joint + 1} was turned")


def _counts_fit_the_angles(bench: ConformBench) -> None:
    with bench.opened() as device:
        for tick in range(EXCHANGES):
            measured = device.read(tick)
            device.write(tick, (0.0, 0.0))
            device.driver.pause()
        measured = device.read(EXCHANGES)
        for axis, joint in enumerate(device.file.joints):
            shaft = joint.direction * (measured.joint_angle[axis] - joint.offset)
            expected = measured.count[axis] * joint.quantum
            off = (shaft - expected + pi) % (2 * pi) - pi
            if abs(off) > joint.quantum:
                raise NotConform(
                    f"joint {axis + 1} has {measured.count[axis]} counts and {shaft:.4f} rad: "
                    "counts_per_turn is wrong"
                )


def _switch_is_told(bench: ConformBench) -> None:
    if not bench.kind.has_input:
        raise NotTried("it tells of no switch")
    with bench.opened() as device:
        driver = device.driver
        for closed, words in ((False, "Let go of"), (True, "Press and hold"), (False, "Let go of")):
            bench.do(f"{words} the switch on the board", "input", closed=closed)
            told = [idle(driver).input_held for _ in range(EXCHANGES)]
            if told[-1] is not closed:
                state = "closed" if closed else "open"
                raise NotConform(f"the switch was {state}, and the board told {told[-1]}")


MOTION_RULES = (
    ConformRule("angle", "Angles have the file's sign and scale.", _angles_have_sign_and_scale),
    ConformRule("counts", "Counts and angles say the same.", _counts_fit_the_angles),
    ConformRule("switch", "A switch on the board is seen open and closed.", _switch_is_told),
)
