"""A run on a terminal of its own, pushing on motors at the other end of a wire, that can be ended.

The terminal is the run's controlling one: what is typed into it, and its being closed, is what a
person does. Nothing here asks the product what it did: torques are the motors' own.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
QUANSER_HOME = [2.2873, 0.8543]
DRIVE = {"torque_constant": 0.0364, "amplifier": 0.5}
FILES: dict[str, dict[str, Any]] = {
    "haply": {"home": [2.4, 0.9], "estop": "confirmed"},
    "cobs": {"home": QUANSER_HOME},
    "odrive": {
        "home": QUANSER_HOME,
        "joints": [{"counts_per_turn": 8192}] * 2,
        "settings": {"watchdog": {"timeout": 0.02}},
    },
    "canopen": {
        "home": QUANSER_HOME,
        "joints": [{"counts_per_turn": 20000, "drive": DRIVE}] * 2,
    },
    "cia402": {"home": QUANSER_HOME, "joints": [{"counts_per_turn": 20000}] * 2},
}
"""Per board: the device file."""
URLS = {
    "haply": "haply://{port}",
    "cobs": "cobs://{port}",
    "odrive": "odrive+slcan://{port}?nodes=0,1&sleep_after_open=0",
    "canopen": "canopen+slcan://{port}?nodes=1&sleep_after_open=0",
    "cia402": "cia402+slcan://{port}?nodes=1,2&sleep_after_open=0",
}
SCENARIO = """
cohaptic: 1
title: A torque that pushes on
duration: 60
rates: {{control: 1024}}
components:
  finger: {{device: {{url: "{url}", file: {file}}}, rate: control}}
  push: {{python: "pushing:Push", rate: control}}
connections:
  - push.motor_torque -> finger.motor_torque
record: [finger.applied_torque]
"""
PATIENCE = 60.0


@dataclass
class Seen:
    """What the motors were told: (time, torque 1, torque 2), and when they did not look."""

    torques: list[tuple[float, float, float]]
    zeros: list[float]
    """When they answered that they are at zero."""
    away: list[tuple[float, float]]

    def first_zero(self, after: float) -> float | None:
        """Seconds from ``after`` to the first zero that is followed by nothing but zeros."""
        # By order and not by time: the frames of two drives may come in one read.
        hot = [number for number, (_, *pair) in enumerate(self.torques) if any(pair)]
        zeros = self.torques[hot[-1] + 1 :] if hot else [r for r in self.torques if r[0] > after]
        return max(0.0, zeros[0][0] - after) if zeros else None

    def first_answer(self, after: float) -> float | None:
        """Seconds from ``after`` to the first answer that confirms the zero that lasts."""
        found = self.first_zero(after)
        return next(
            (t - after for t in self.zeros if found is not None and t >= after + found), None
        )

    def pushes(self, at: float) -> bool:
        """Whether the last torque before that time is none of zero."""
        before = [pair for t, *pair in self.torques if t <= at]
        return bool(before) and any(before[-1])

    def busy(self, begin: float, seconds: float) -> float:
        """How long the motors' own process was kept from looking meanwhile (s)."""
        return sum(length for t, length in self.away if begin <= t <= begin + seconds + length)


@dataclass
class Run:
    """The command, on its terminal, with its motors."""

    folder: Path
    board: str
    ahead: str = ""
    """What is typed before anything is asked."""
    first: str = ""
    """What the command's process does before it begins (Python)."""
    said: str = ""
    motors: subprocess.Popen = field(init=False)
    command: subprocess.Popen = field(init=False)
    terminal: int | None = None

    def start(self) -> None:
        """Begin, answer what is asked, and wait until it pushes."""
        self.begin()
        self.answer("Type 'enable'", "enable\n")
        self.answer("press Enter", "\n")
        self.wait_until_pushing()

    def begin(self) -> None:
        self.motors = subprocess.Popen(
            [sys.executable, "-m", "tests.support.hil.motors", self.board],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.motors.stdout is not None
        port = self.motors.stdout.readline().strip()
        device = {"driver": self.board, **FILES[self.board]}
        file = self.folder / "device.yaml"
        file.write_text(json.dumps(device))
        scenario = self.folder / "push.yaml"
        scenario.write_text(SCENARIO.format(url=URLS[self.board].format(port=port), file=file))
        (self.folder / "pushing.py").write_text((HERE / "pushing.py").read_text())
        self.terminal, theirs = os.openpty()
        self.command = subprocess.Popen(
            [
                *(sys.executable, "-c", f"{self.first}\nfrom cosim.cli import cli; cli()"),
                *("run", str(scenario)),
                *("--realtime", "--enable-output", "--no-figure"),
                *("--out", str(self.folder / "out")),
            ],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            cwd=self.folder,
            start_new_session=True,
            preexec_fn=_control,
        )
        os.close(theirs)
        if self.ahead:
            self.type(self.ahead)

    def answer(self, question: str, text: str) -> None:
        assert self.terminal is not None
        self.listen_for(question)
        os.write(self.terminal, text.encode())

    def listen_for(self, words: str) -> None:
        end, begin = time.monotonic() + PATIENCE, len(self.said)
        while words not in self.said[begin:]:
            assert time.monotonic() < end, f"never said {words!r}: {self.said}"
            assert self.listen(0.1) or self.command.poll() is None, self.said

    def listen(self, seconds: float) -> bool:
        """Take what the terminal shows; whether there was anything."""
        if self.terminal is None or not select.select([self.terminal], [], [], seconds)[0]:
            return False
        with suppress(OSError):
            text = os.read(self.terminal, 65536).decode(errors="replace")
            self.said += text
            return bool(text)
        return False

    def wait_until_pushing(self) -> None:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            self.listen(0.1)
            if sum(map(abs, self.asked("now"))) > 0.01:
                return
            assert self.command.poll() is None, self.said
        raise AssertionError(f"it never pushed: {self.said}")

    def asked(self, word: str) -> Any:
        assert self.motors.stdin is not None
        assert self.motors.stdout is not None
        self.motors.stdin.write(word + "\n")
        self.motors.stdin.flush()
        return json.loads(self.motors.stdout.readline())

    def seen(self) -> Seen:
        found = self.asked("dump")
        return Seen([tuple(row) for row in found["seen"]], found["zeros"], found["away"])

    @property
    def supervisor(self) -> int:
        return self._child(self.command.pid)

    @property
    def loop(self) -> int:
        return self._child(self.supervisor)

    def _child(self, process: int) -> int:
        try:
            text = Path(f"/proc/{process}/task/{process}/children").read_text()
        except OSError:
            text = ""
        if not text:
            while self.listen(0.5):
                pass
        assert text, f"it had ended before: {self.said}"
        return int(text.split()[0])

    @property
    def processes(self) -> list[int]:
        """The command and all that it started."""
        return _tree(self.command.pid)

    def type(self, key: str) -> None:
        assert self.terminal is not None
        os.write(self.terminal, key.encode())

    def close_terminal(self) -> None:
        assert self.terminal is not None
        os.close(self.terminal)
        self.terminal = None

    def status(self) -> int:
        """The command's exit status; what it still says is taken."""
        end = time.monotonic() + PATIENCE
        while self.command.poll() is None:
            self.listen(0.1)
            assert time.monotonic() < end, f"it does not end: {self.said}"
        while self.listen(0.1):
            pass
        return self.command.returncode

    def end(self) -> None:
        for process in _tree(self.command.pid):
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        self.command.wait()
        if self.terminal is not None:
            os.close(self.terminal)
        self.motors.kill()
        self.motors.wait()
        assert self.motors.stdin is not None
        assert self.motors.stdout is not None
        self.motors.stdin.close()
        self.motors.stdout.close()


def _control() -> None:
    """In the child: the terminal on standard input becomes its controlling one."""
    import fcntl
    import termios

    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def _tree(process: int) -> list[int]:
    found = [process]
    with suppress(OSError):
        for child in Path(f"/proc/{process}/task/{process}/children").read_text().split():
            found += _tree(int(child))
    return found
