"""Rules on frames that arrive damaged; for boards on a serial line that check what they get."""

from __future__ import annotations

from collections.abc import Callable

from hil.device.driver import Driver
from hil.setup.conform.bench import EXCHANGES, ConformBench, idle
from hil.setup.conform.errors import NotConform, NotTried
from hil.setup.conform.rule import ConformRule
from hil.wire.serial_port import SerialPort

RECOVER = 3
"""Whole exchanges after which a board has to be in step again."""
JUNK = bytes(range(1, 256)) + b"\xff\x00\x80" * 20


def _each_bit_counts(bench: ConformBench) -> None:
    with bench.opened() as device:
        port, length = _line(device.driver)
        for bit in range(8 * length):

            def flip(frame: bytes, bit: int = bit) -> bytes:
                spoiled = bytearray(frame)
                spoiled[bit // 8] ^= 1 << (bit % 8)
                return bytes(spoiled)

            if _is_answered(device.driver, port, flip):
                raise NotConform(f"a command with bit {bit} flipped was answered as if whole")
            _in_step(device.driver, f"a flipped bit {bit}")


def _each_cut_is_survived(bench: ConformBench) -> None:
    with bench.opened() as device:
        port, length = _line(device.driver)
        for size in range(length):

            def cut(frame: bytes, size: int = size) -> bytes:
                return frame[:size]

            if _is_answered(device.driver, port, cut):
                raise NotConform(f"the first {size} bytes of a command were answered as if whole")
            _in_step(device.driver, f"a command of {size} bytes")


def _junk_is_survived(bench: ConformBench) -> None:
    with bench.opened() as device:
        port, _ = _line(device.driver)
        for junk in (JUNK, bytes(100), b"\xff" * 300):
            _is_answered(device.driver, port, lambda _, junk=junk: junk)
            _in_step(device.driver, f"{len(junk)} bytes of junk")


def _line(driver: Driver) -> tuple[SerialPort, int]:
    """The driver's port, in step, and how long a command for zero is."""
    port = driver.port
    if port is None:
        raise NotTried("it is on no serial line of ours: its bus or its maker checks frames")
    if not driver.checks_frames:
        raise NotTried("its protocol has no checksum: a flipped bit in a torque cannot be noticed")
    sizes: list[int] = []

    def measure(frame: bytes) -> bytes:
        sizes.append(len(frame))
        return frame

    port.spoil = measure
    idle(driver)
    port.spoil = None
    _in_step(driver, "nothing")
    return port, min(sizes)


def _is_answered(driver: Driver, port: SerialPort, spoil: Callable[[bytes], bytes]) -> bool:
    """Whether one spoiled command is answered; answers from before it are taken first."""
    driver.receive()
    port.spoil = spoil
    driver.send_zero()
    port.spoil = None
    driver.pause()
    return driver.receive().sample is not None


def _in_step(driver: Driver, after: str) -> None:
    for _ in range(EXCHANGES):
        if all(idle(driver).sample is not None for _ in range(RECOVER)):
            return
    raise NotConform(f"after {after} it answers no more")


FRAME_RULES = (
    ConformRule("bits", "A command with a flipped bit is none.", _each_bit_counts),
    ConformRule("cuts", "A command that ends early is none.", _each_cut_is_survived),
    ConformRule("junk", "Junk is survived.", _junk_is_survived),
)
