"""Drivers around makers' libraries, on fakes of those whose board is in another process."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.base.system.pulse import Pulse
from cosim.cli import cli
from hil.device.contract import ZERO, State, WriteOutcome
from hil.device.device import Device
from hil.device.errors import ActivationRefused, Cause, DeviceError, DeviceGone
from hil.device.judge import SETTLING_REPLIES
from hil.device.warnings import warnings_of
from hil.drivers.mock.driver import MockDriver
from hil.safety.permission import ask, emulated
from hil.setup.address import parse
from hil.setup.device_file import default
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find
from tests.support.hil.vendor_board import RemoteBoard
from tests.support.hil.vendor_fakes import FAKES, Maker

URLS = {"quanser": "quanser://q8_usb/0", "nidaqmx": "nidaqmx://Dev1", "moteus": "moteus:///dev/usb"}
PUSH = (0.02, -0.01)
CARDS = ["nidaqmx", "quanser"]


@dataclass
class Rig:
    """A driver on a fake; a tick passes on the board after every exchange."""

    device: Device
    maker: Maker
    tick: int = 0

    def exchange(self, ticks: int, command=ZERO):
        done = []
        for _ in range(ticks):
            measured = self.device.read(self.tick)
            done.append((measured, self.device.write(self.tick, command)))
            self.maker.board.tick()
            self.tick += 1
        return done

    def ready(self) -> Rig:
        self.device.configure()
        self.device.home()
        self.exchange(64)
        return self

    def active(self) -> Rig:
        self.ready().device.activate()
        return self

    @property
    def torque(self):
        return self.maker.board.state()["torque"]


@pytest.fixture
def board() -> Iterator[RemoteBoard]:
    made = RemoteBoard()
    yield made
    made.close()


@pytest.fixture(params=sorted(FAKES))
def name(request) -> str:
    return request.param


@pytest.fixture
def rig(name: str, board: RemoteBoard, monkeypatch) -> Iterator[Rig]:
    maker = Maker(board)
    for module, fake in FAKES[name](maker).items():
        monkeypatch.setitem(sys.modules, module, fake)
    file = parse_file({"driver": name, "home": list(board.state()["angle"])})
    device = Device(
        find(name),
        parse(URLS[name] + "?lockstep=1"),
        file,
        tick=Fraction(1, 1024),
        permission=emulated("a fake", None),
    )
    device.driver.pause = board.tick
    yield Rig(device, maker)
    maker.broken.clear()
    device.close()
    assert maker.open == 0, "everything that was opened is closed"


def test_torques_and_angles_are_the_boards(rig: Rig):
    rig.active()
    start = rig.device.read(rig.tick).joint_angle
    for _ in range(600):
        truth = rig.maker.board.state()["angle"]
        ((measured, sent),) = rig.exchange(1, PUSH if rig.tick > 70 else ZERO)
        assert measured.sample_age == 0
        for axis in (0, 1):
            near = pytest.approx(truth[axis], abs=rig.device.file.quantum)
            assert measured.joint_angle[axis] == near, "as old as the FMU's: no latency"
        assert rig.torque == pytest.approx(sent.torque, abs=1e-12)
        assert all(
            abs(given) <= abs(allowed)
            for given, allowed in zip(sent.torque, sent.limited, strict=True)
        )
    assert rig.device.state is State.ACTIVE, rig.device.fault_sentence()
    assert abs(truth[0] - start[0]) > 5 * rig.device.file.quantum, "the torque moves the handle"


def test_it_is_said_to_be_untested_on_hardware_and_has_no_port_to_share(rig: Rig):
    assert "never hardware" in " ".join(warnings_of(rig.device))
    assert rig.device.driver.shares_port is False


def test_without_a_permission_the_board_gets_zero(rig: Rig):
    rig.device.permission = None
    rig.active()
    exchanged = rig.exchange(100, (0.005, 0.0))
    assert exchanged[-1][1].limited[0] > 0.0
    assert rig.torque == ZERO


def test_an_error_while_reading_is_zero_and_fault_in_the_same_tick(rig: Rig):
    rig.active().exchange(200, (0.008, 0.008))
    assert rig.torque != ZERO
    rig.maker.broken = {"read"}
    rig.exchange(1, (0.008, 0.008))
    assert rig.device.state is State.FAULT
    assert rig.device.fault.cause is Cause.PORT
    assert rig.torque == ZERO
    assert not rig.device.homed
    rig.maker.broken = set()
    rig.exchange(40, (0.008, 0.008))
    assert rig.device.state is State.FAULT, "latched"
    assert rig.device.outcome is WriteOutcome.ZERO_CONFIRMED


def test_an_error_while_writing_leaves_it_to_the_watchdog(rig: Rig):
    rig.active().exchange(200, (0.008, 0.008))
    rig.maker.broken = {"write"}
    rig.exchange(60, (0.008, 0.008))
    assert rig.device.state is State.FAULT
    assert rig.device.fault.cause is Cause.PORT
    assert rig.device.outcome is WriteOutcome.WATCHDOG
    assert rig.torque == ZERO, "the board has dropped it"
    assert rig.maker.board.state()["expired"]


def test_a_watchdog_that_expired_is_a_fault(rig: Rig):
    rig.active().exchange(200, (0.008, 0.008))
    before = rig.torque
    rig.maker.board.tick(15)
    assert rig.torque == before
    rig.maker.board.tick(10)
    assert rig.torque == ZERO
    rig.exchange(1, (0.008, 0.008))
    assert rig.device.state is State.FAULT
    assert rig.torque == ZERO
    rig.exchange(40, (0.008, 0.008))
    assert rig.device.settled


def test_a_board_without_a_watchdog_is_never_given_output(rig: Rig):
    rig.maker.has_watchdog = False
    rig.device.driver.pulse = Pulse()
    object.__setattr__(rig.device.file, "estop_confirmed", True)
    rig.ready()
    assert not rig.device.watchdog.verified
    for permission in (emulated("a fake", None), ask("x", [], lambda text: "enable")):
        rig.device.permission = permission
        with pytest.raises(ActivationRefused, match="watchdog"):
            rig.device.activate()
    rig.device.permission = None
    rig.device.activate()
    rig.exchange(50, (0.005, 0.0))
    assert rig.torque == ZERO


def test_close_leaves_zero(rig: Rig):
    rig.active().exchange(200, (0.008, 0.008))
    assert rig.torque != ZERO
    rig.device.close()
    assert rig.torque == ZERO
    assert rig.maker.open == 0
    rig.device.configure()
    assert not rig.device.homed


def test_a_loop_that_is_killed_leaves_it_to_the_board(rig: Rig):
    rig.active().exchange(200, (0.008, 0.008))
    loop = os.fork()
    if loop == 0:
        with suppress(BaseException):
            rig.exchange(5, (0.008, 0.008))
            os.kill(os.getpid(), signal.SIGKILL)
        os._exit(1)
    _, status = os.waitpid(loop, 0)
    assert os.WTERMSIG(status) == signal.SIGKILL
    assert rig.torque != ZERO
    rig.maker.board.tick(25)
    assert rig.torque == ZERO


def test_what_cannot_be_opened_is_said(rig: Rig):
    rig.maker.broken = {"open"}
    with pytest.raises(DeviceGone):
        rig.device.configure()
    assert rig.device.state is State.UNCONFIGURED


@pytest.mark.parametrize("name", sorted(FAKES))
def test_a_package_that_is_missing_is_named_with_its_installation(name: str, monkeypatch):
    module = "quanser.hardware" if name == "quanser" else name
    monkeypatch.setitem(sys.modules, module, None)
    device = Device(find(name), parse(URLS[name]), default(name))
    with pytest.raises(InputError, match=rf"'{module}'.*install"):
        device.configure()


def test_a_url_without_a_place_is_refused(name: str, monkeypatch):
    for module, fake in FAKES[name](Maker(None)).items():
        monkeypatch.setitem(sys.modules, module, fake)
    with pytest.raises(InputError, match=f"write {name}://"):
        Device(find(name), parse(f"{name}://"), default(name)).configure()


@pytest.mark.parametrize("timeout", [0, 1, "soon", True, -0.02])
def test_a_watchdog_too_slow_for_a_hand_is_refused(name: str, timeout):
    with pytest.raises(InputError, match=r"watchdog\.timeout"):
        parse_file({"driver": name, "settings": {"watchdog": {"timeout": timeout}}})


@pytest.mark.parametrize("name", ["moteus"])
def test_answers_that_fail_to_come_age_and_end_in_a_fault(rig: Rig):
    rig.active().exchange(300, (0.01, -0.01))
    before = rig.torque[0]
    rig.maker.silent = True
    ages = [measured.sample_age for measured, _ in rig.exchange(5, (0.01, -0.01))]
    assert ages == [1, 2, 3, 4, 5]
    assert 0.0 < rig.torque[0] < before
    rig.exchange(6, (0.01, -0.01))
    assert rig.device.state is State.FAULT
    assert rig.device.fault.cause is Cause.STALE
    assert rig.torque == ZERO


@pytest.mark.parametrize("name", ["moteus"])
@pytest.mark.parametrize("mode", [b"12", b"15", b"10"])
def test_a_servo_that_would_not_stop_on_a_timeout_is_not_given_output(rig: Rig, mode: bytes):
    rig.maker.timeout_mode = mode
    rig.ready()
    with pytest.raises(ActivationRefused, match="watchdog"):
        rig.device.activate()


@pytest.mark.parametrize("name", ["moteus"])
def test_a_servo_in_fault_is_noticed(rig: Rig):
    rig.active().exchange(100, (0.005, 0.0))
    rig.maker.mode[2] = 1
    rig.exchange(1, (0.005, 0.0))
    assert rig.device.fault.cause is Cause.BOARD
    assert "mode 1" in rig.device.fault_sentence()


@pytest.mark.parametrize("name", ["moteus"])
def test_a_servo_that_does_not_stay_stopped_is_noticed_before_it_is_active(rig: Rig):
    rig.ready()
    rig.maker.mode[2], rig.maker.deaf = 15, True
    rig.exchange(SETTLING_REPLIES)
    assert rig.device.state is State.INACTIVE, "it may be about an earlier command"
    rig.exchange(1)
    assert rig.device.fault.cause is Cause.BOARD
    assert "moteus 2 was told to stop, and is in mode 15" in rig.device.fault_sentence()


@pytest.mark.parametrize("name", ["moteus", "nidaqmx"])
def test_a_position_that_is_no_number_is_a_fault_and_zero(rig: Rig):
    rig.active().exchange(200, (0.008, 0.008))
    rig.maker.no_number = True
    rig.exchange(1, (0.008, 0.008))
    assert rig.device.state is State.FAULT
    assert "no number" in rig.device.fault_sentence()
    assert rig.torque == ZERO


@pytest.mark.parametrize("name", ["moteus"])
def test_controllers_that_do_not_answer_are_an_error(rig: Rig):
    rig.maker.silent = True
    with pytest.raises(DeviceError, match="do not answer"):
        rig.device.configure()


@pytest.mark.parametrize("name", CARDS)
def test_a_card_is_fed_by_writing_alone(rig: Rig):
    """Else reading would keep a stale torque alive."""
    rig.active().exchange(200, (0.008, 0.008))
    for _ in range(25):
        rig.device.read(rig.tick)
        rig.maker.board.tick()
    assert rig.torque == ZERO


@pytest.mark.parametrize("shared", [True, False])
def test_the_control_loop_itself_opens_what_cannot_be_shared(shared: bool, tmp_path, monkeypatch):
    """Who opens it does not depend on whether this machine then keeps 1024 Hz."""
    opened, whole = tmp_path / "opened", MockDriver.open

    def note(device: MockDriver) -> None:
        opened.write_text(f"{os.getpid()}")
        whole(device)

    monkeypatch.setattr(MockDriver, "shares_port", shared)
    monkeypatch.setattr(MockDriver, "open", note)
    run = ("run", "two_users_box", "--with", "scenarios/devices/mock.yaml", "--realtime")
    rest = ("--duration", "0.05 s", "--set", "expect=~", "--no-figure", "--json")
    CliRunner().invoke(cli, [*run, *rest, "--out", str(tmp_path / "run")])
    opener = int(opened.read_text())
    assert (opener == os.getpid()) is shared, "the command opens the others"
