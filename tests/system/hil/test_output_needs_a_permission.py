"""Nothing moves a motor without ``--enable-output`` and a confirmation."""

from __future__ import annotations

import threading
from fractions import Fraction

import pytest

from cosim.base.system.pulse import Pulse
from hil.device.contract import Watchdog
from hil.device.device import Device
from hil.device.errors import ActivationRefused
from hil.drivers.mock.driver import MockDriver
from hil.safety.permission import Permission, ask, dead_man, emulated
from hil.safety.safeguards import check_safeguards
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.setup.session import Session
from tests.support.hil.hil_bench import REST_ANGLE, Puppet, mock


def test_a_permission_cannot_be_made_by_hand():
    with pytest.raises(TypeError):
        Permission("because")


def test_only_the_word_confirms():
    assert ask("x", [], lambda text: "enable").how == "confirmed at the prompt"
    for answer in ("", "y", "yes", "Enable", "no"):
        with pytest.raises(ActivationRefused):
            ask("x", [], lambda text, answer=answer: answer)


def test_the_prompt_shows_every_warning():
    shown = []
    ask("x", ["cut the power"], lambda text: shown.append(text) or "enable")
    assert "cut the power" in shown[0]


def test_yes_is_for_proved_emulators():
    with pytest.raises(ActivationRefused, match="prove"):
        emulated("haply", "its URL names no emulator")
    with pytest.raises(ActivationRefused):
        dead_man("haply", lambda: False)


def test_a_session_is_dry_unless_told_otherwise():
    device = mock(Puppet(), output=False)
    assert Session().permission(device) is None
    assert Session(yes=True).permission(device) is None
    assert Session(enable_output=True, yes=True).permission(device) is not None


class Real(MockDriver):
    """As if it were hardware."""

    driver = "mock"
    in_process = False
    watchdog = Watchdog()


def real(url="mock:///dev/ttyACM0", file=None, **options):
    permission = ask("x", [], lambda text: "enable")
    return Device(
        Real,
        parse(url),
        parse_file({"driver": "mock", **(file or {})}),
        permission=permission,
        **options,
    )


def test_yes_does_not_do_for_hardware():
    with pytest.raises(ActivationRefused, match="prove"):
        Session(enable_output=True, yes=True).permission(real())


def test_hardware_without_watchdog_needs_a_supervisor_and_a_switch():
    with pytest.raises(ActivationRefused, match="--realtime"):
        check_safeguards(real())
    with pytest.raises(ActivationRefused, match="estop: confirmed"):
        check_safeguards(real(pulse=Pulse()))
    check_safeguards(real(pulse=Pulse(), file={"estop": "confirmed"}))


def test_a_network_is_no_place_for_a_motor():
    with pytest.raises(ActivationRefused, match="network"):
        check_safeguards(real("mock+socket://host:1", pulse=Pulse(), file={"estop": "confirmed"}))


def test_another_thread_in_the_process_is_refused():
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    try:
        with pytest.raises(ActivationRefused, match="thread"):
            check_safeguards(real(pulse=Pulse(), file={"estop": "confirmed"}))
    finally:
        done.set()
        thread.join()


def test_a_rate_at_which_nothing_could_be_dropped_in_time_gets_no_output():
    slow = mock(Puppet(), tick=Fraction(1, 128))
    with pytest.raises(ActivationRefused, match="128 Hz"):
        check_safeguards(slow)
    check_safeguards(mock(Puppet(), tick=Fraction(1, 512)))


@pytest.mark.parametrize("ahead", [False, True])
def test_a_dead_man_input_is_asked_whoever_opens_the_board(monkeypatch, ahead: bool):
    """Where the loop opens it, people are asked before; the input is held from then on, too."""
    monkeypatch.setattr("hil.setup.session.wait_until_held", lambda *_: True)
    held, questions = [True], []
    session = Session(
        enable_output=True,
        dead_man=lambda _: lambda: held[0],
        prompt=lambda text: questions.append(text) or "enable",
    )
    device = real(file={"home": list(REST_ANGLE)})
    if ahead:
        session.ask_ahead(device)
    given = session.permission(device)
    session.hold_home_pose(device)
    assert given is not None
    assert given.is_held is not None, "nobody asks the input: the board pushes without a hand on it"
    assert given.is_held()
    held[0] = False
    assert not given.is_held()
    (question,) = questions
    assert question.startswith("Hold the handle")


@pytest.mark.parametrize("ahead", [False, True])
def test_a_board_is_homed_by_nobody_where_nobody_is_at_a_terminal(monkeypatch, ahead: bool):
    """A dead-man input that is held says that there is a hand, not where it holds the handle."""
    monkeypatch.setattr("hil.setup.session.wait_until_held", lambda *_: True)
    session = Session(enable_output=True, dead_man=lambda _: lambda: True, prompt=None)
    device = real(file={"home": list(REST_ANGLE)})
    if ahead:
        session.ask_ahead(device)
    assert session.permission(device) is not None
    with pytest.raises(ActivationRefused, match="is not homed: nobody is at a terminal"):
        session.hold_home_pose(device)
