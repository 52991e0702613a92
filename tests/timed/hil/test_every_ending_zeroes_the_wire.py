"""However a paced run ends, the motors are told zero in time, and the command says so or says not.

Measured on the wire, by motors that read it themselves. A time holds but for what the motors'
process was itself kept from looking: the probe beside it.
"""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest

from tests.support.hil.ending_table import (
    BOARDS,
    ENDINGS,
    STALL,
    check_every_tick,
    end_it,
    pushing,
)
from tests.support.hil.endings import Run
from tests.support.machine import timed


@pytest.mark.parametrize("how", ENDINGS)
@pytest.mark.parametrize("board", BOARDS)
def test_the_motors_are_told_zero_in_time(how: str, board: str, tmp_path: Path):
    end_it(how, board, tmp_path)


@pytest.mark.parametrize("how", ["left alone", "loop killed", "supervisor and loop killed"])
def test_a_zero_that_nobody_confirmed_is_said_to_be_unknown(how: str, tmp_path: Path):
    """The board hangs, so to say: the motors' process stands still, and answers nothing."""

    def attempt(number: int) -> str | None:
        try:
            with pushing(tmp_path / str(number), "haply") as run:
                run.motors.send_signal(signal.SIGSTOP)
                if how in ENDINGS:
                    ENDINGS[how].act(run)
                try:
                    assert run.status() == 1, run.said
                    assert "output unknown, cut the power" in run.said, run.said
                finally:
                    run.motors.send_signal(signal.SIGCONT)
        except AssertionError as error:
            return str(error)
        return None

    timed(attempt, tolerates=STALL)


@pytest.mark.parametrize("delay", [0.0, 0.2, 0.6, 1.2])
def test_a_command_killed_while_its_devices_open_leaves_nobody_who_pushes(
    delay: float, tmp_path: Path
):
    """Wherever it is: still opening, proving a watchdog, or at its first torques."""

    def attempt(number: int) -> str | None:
        folder = tmp_path / str(number)
        folder.mkdir()
        run = Run(folder, "cobs")
        try:
            run.begin()
            run.answer("Type 'enable'", "enable\n")
            run.answer("press Enter", "\n")
            time.sleep(delay)
            others = [process for process in run.processes if process != run.command.pid]
            at = time.monotonic()
            os.kill(run.command.pid, signal.SIGKILL)
            time.sleep(2.5)
            seen = run.seen()
            check_every_tick(seen.torques)
            allowed = at + 0.05 + seen.busy(at, 0.05)
            late = [(t - at, *pair) for t, *pair in seen.torques if t > allowed and any(pair)]
            assert not late, f"still pushed {late[-1][0]:.3f} s after the command was killed"
            left = [process for process in others if is_alive(process)]
            assert not left, f"{len(left)} of its processes still run"
        except AssertionError as error:
            return str(error)
        finally:
            run.end()
        return None

    timed(attempt, tolerates=STALL)


def is_alive(process: int) -> bool:
    try:
        text = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return text.rsplit(")", 1)[1].split()[0] not in {"Z", "X"}


def test_what_was_typed_before_the_question_is_no_answer(tmp_path: Path):
    run = Run(tmp_path, "haply", ahead="enable\n\n")
    try:
        run.begin()
        run.listen_for("Type 'enable'")
        for _ in range(10):
            run.listen(0.1)
        assert "press Enter" not in run.said
        assert run.command.poll() is None, "it waits for its answer"
    finally:
        run.end()


@pytest.mark.parametrize("question", ["Type 'enable'", "press Enter"])
def test_ctrl_c_at_a_question_ends_without_a_word_of_python(question: str, tmp_path: Path):
    run = Run(tmp_path, "cobs")
    try:
        run.begin()
        run.listen_for("Type 'enable'")
        if question == "press Enter":
            run.type("enable\n")
            run.listen_for(question)
        run.type("\x03")
        assert run.status() == 1
        assert run.said.splitlines()[-1] == "Aborted!", run.said
        assert not any(word in run.said for word in ("Error", "Interrupt", "Traceback", "failed"))
        assert not any(any(pair) for _, *pair in run.seen().torques)
    finally:
        run.end()
