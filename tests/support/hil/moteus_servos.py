"""Two moteus controllers on a serial line (a pseudo-terminal), in a process of their own.

Written from mjbots' published register and multiplex tables, without their package. A tick passes
with every query to the first servo, or when the test says so: nothing depends on a clock.
"""

from __future__ import annotations

import multiprocessing
import os
import select
import struct
import tty
from math import pi
from typing import Any

from hil.emulation.plant import SimulatedPantograph

PARAMETERS = {"device": 0, "initial_tip_position": (0.0425, 0.2)}
TICK = 1 / 1024
SIZES = {0x00: "<b", 0x04: "<h", 0x08: "<i", 0x0C: "<f"}
MODE, POSITION, FAULT = 0x000, 0x001, 0x00F
TORQUE_SET, MAXIMUM, TIMEOUT_SET = 0x022, 0x025, 0x027
KP, KD, ILIMIT = 0x023, 0x024, 0x02B


def crc8(data: bytes) -> int:
    """Polynomial 0x97, highest bit first: what moteus' UART puts at the end of a line."""
    register = 0
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = (register << 1 ^ (0x97 if register & 0x80 else 0)) & 0xFF
    return register


def say(descriptor: int, line: str) -> None:
    text = f"{line} ".encode()
    os.write(descriptor, text + b"*%02X\r\n" % crc8(text))


class Servo:
    """One controller's registers."""

    def __init__(self) -> None:
        self.mode, self.torque, self.due = 0, 0.0, None
        self.written: dict[int, float] = {}
        self.lines = b""

    def take(self, frame: bytes, turns: float, now: float) -> bytes:
        """What a frame's subframes do, and the answer to its reads."""
        answer, place, written = b"", 0, {}
        while place < len(frame):
            kind = frame[place]
            place += 1
            if kind == 0x50:
                continue
            if kind == 0x40:
                size = frame[place + 1]
                self.say(frame[place + 2 : place + 2 + size])
                place += 2 + size
                continue
            if kind in {0x42, 0x44}:
                most = frame[place + kind // 0x44 + 1]
                part, self.lines = self.lines[:most], self.lines[most:]
                head = bytes((0x41, 1)) if kind == 0x42 else bytes((0x43, 1, 1))
                answer += head + bytes((len(part),)) + part
                place += 2 + kind // 0x44
                continue
            count = kind & 3
            if not count:
                count, place = frame[place], place + 1
            register, place = frame[place], place + 1
            form = SIZES[kind & 0x0C]
            for number in range(register, register + count):
                if kind & 0xF0 == 0x00:
                    (written[number],) = struct.unpack_from(form, frame, place)
                    place += struct.calcsize(form)
                else:
                    value = {MODE: self.mode, POSITION: turns}.get(number, 0)
                    answer += bytes((0x20 | kind & 0x0C | 1, number)) + struct.pack(
                        form, value if form == "<f" else int(value)
                    )
        if written:
            self.write(written, now)
        return answer

    def write(self, written: dict[int, float], now: float) -> None:
        if written.get(MODE) == 0:
            self.mode, self.torque, self.due = 0, 0.0, None
        if written.get(MODE) == 10 and self.mode in {0, 10}:
            assert written[KP] == written[KD] == written[ILIMIT] == 0.0
            bound = written[MAXIMUM]
            self.mode, self.torque = 10, max(-bound, min(bound, written[TORQUE_SET]))
            self.due = now + written[TIMEOUT_SET]

    def say(self, asked: bytes) -> None:
        if asked.strip() == b"conf get servo.timeout_mode":
            self.lines += b"0\r\n"

    def tick(self, now: float) -> None:
        if self.mode == 10 and self.due is not None and now > self.due:
            self.mode, self.torque = 11, 0.0


def serve(pipe: Any) -> None:
    """Run until the test hangs up."""
    body, servos, text = SimulatedPantograph(PARAMETERS), {1: Servo(), 2: Servo()}, b""
    master, slave = os.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    pipe.send((os.ttyname(slave), body.angle()))
    now = largest = 0.0

    def pass_ticks(ticks: int) -> None:
        nonlocal now, largest
        for _ in range(ticks):
            now += TICK
            for servo in servos.values():
                servo.tick(now)
            body.step((servos[1].torque, servos[2].torque))
            largest = max(largest, *(abs(servo.torque) for servo in servos.values()))

    while True:
        ready, _, _ = select.select([master, pipe.fileno()], [], [])
        if pipe.fileno() in ready:
            try:
                asked = pipe.recv()
            except EOFError:
                return
            pass_ticks(asked.get("ticks", 0))
            pipe.send(
                {
                    "angle": body.angle(),
                    "torque": (servos[1].torque, servos[2].torque),
                    "modes": [servo.mode for servo in servos.values()],
                    "largest": largest,
                }
            )
        if master in ready:
            *lines, text = (text + os.read(master, 65536)).split(b"\n")
            for line in lines:
                words = line.split()
                if words[:2] != [b"can", b"send"]:
                    continue
                identifier, frame = int(words[2], 16), bytes.fromhex(words[3].decode())
                number = identifier & 0x7F
                pass_ticks(1 if number == 1 and identifier & 0x8000 else 0)
                assert crc8(line[: line.rfind(b"*")]) == int(line.rstrip()[-2:], 16)
                say(master, "OK")
                turns = body.angle()[number - 1] / (2 * pi)
                answer = servos[number].take(frame, turns, now)
                if identifier & 0x8000 and answer:
                    say(master, f"rcv {number << 8:04x} {answer.hex()} E B F")


class Servos:
    """The process, and what the test asks it."""

    def __init__(self) -> None:
        context: Any = multiprocessing.get_context("forkserver")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self.path, self.home = self._pipe.recv()

    def ask(self, **values: Any) -> dict[str, Any]:
        self._pipe.send(values)
        return self._pipe.recv()

    def close(self) -> None:
        self._pipe.close()
        self._process.join(10)
        self._process.close()
