"""What a newcomer meets first: the list of scenarios, a starter of one's own, completion."""

from __future__ import annotations

import itertools
import json
import os
import pty
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.cli.first_steps.starter import GROUNDS, Answers, Ground, ground, starter
from cosim.reading import load
from cosim.scenario.source.bundled import bundled_scenarios
from tests.support.command import COHAPTIC, cohaptic


def test_every_bundled_scenario_has_a_sentence_and_loads() -> None:
    found = bundled_scenarios()
    assert {"two_users_box", "thesis/four_users"} <= {each.name for each in found}
    for each in found:
        assert each.title, each.name
        assert load(each.name).title


def test_a_picture_is_drawn(tmp_path: Path) -> None:
    from PIL import Image

    done = cohaptic(
        *("scenarios", "thesis/rigid_contact", "--pictures", "p", "--json"), folder=tmp_path
    )
    (entry,) = json.loads(done.stdout)["scenarios"]
    with Image.open(tmp_path / entry["picture"]) as picture:
        assert picture.size == (480, 360)
        colours = picture.convert("RGB").getcolors(1 << 24)
    assert colours is not None
    assert len(colours) > 20


def test_an_unknown_name_is_refused(tmp_path: Path) -> None:
    done = cohaptic("scenarios", "two_user_box", folder=tmp_path)
    assert done.returncode == 2
    assert "Did you mean two_users_box?" in done.stderr


@pytest.mark.parametrize("below", GROUNDS, ids=lambda each: each.name)
def test_a_starter_is_a_scenario_with_what_was_asked_for(below: Ground, tmp_path: Path) -> None:
    given = {"motion": below.motion, "users": below.users, "architecture": below.architecture}
    found = ground({key: value or None for key, value in given.items()}, lambda _, known: known[0])
    assert found == below
    networked = below.users != "1"
    answers = Answers(3 if networked else None, 0.25 if networked else None, 0.35, "2 s")
    file = tmp_path / "mine.yaml"
    file.write_text(starter(below.name, answers, "mine"))
    scenario = load(file)
    assert float(scenario.duration) == 2.0
    masses = [
        part.parameters["mass"]
        for part in scenario.components.values()
        if "mass" in part.parameters and part.source != "hand"
    ]
    assert masses
    assert {str(mass) for mass in masses} <= {"0.35", "0.35 kg"}
    ways = [way for each in scenario.channels.values() for way in (each.forward, each.backward)]
    assert bool(ways) == networked
    assert all("loss" in way.impairments for way in ways)


@pytest.mark.parametrize("written", ["400 g", "0.4 kg", "0.4"])
def test_the_mass_that_is_offered_is_the_scenarios_in_whatever_unit(
    written: str, tmp_path: Path
) -> None:
    """One of 400 g was offered as '400 g kg', which nobody could take."""
    below = tmp_path / "below.yaml"
    parts = ", ".join(f"object_{n}: {{parameters: {{mass: {written}}}}}" for n in (1, 2))
    below.write_text(f"cohaptic: 1\ninclude: single_axis_distributed\ncomponents: {{{parts}}}\n")
    offered: dict[str, str] = {}

    def ask(question: str, default: str, judge: Callable[[str], None]) -> str:
        judge(default)
        offered[question] = default
        return default

    starter(str(below), Answers(None, None, None, None), "mine", ask)
    assert offered["Mass of the object"] == "0.4 kg"


def test_combinations_without_a_ground_are_refused() -> None:
    traits = itertools.product(
        ("plane", "axis"), ("1", "2", "3", "4"), ("distributed", "centralized", None)
    )
    for motion, users, architecture in traits:
        given = {"motion": motion, "users": users, "architecture": architecture}
        fits = any(
            (each.motion, each.users) == (motion, users)
            and architecture in {None, each.architecture}
            for each in GROUNDS
        )
        if fits:
            assert ground(given, lambda _, known: known[0]).users == users
        else:
            with pytest.raises(InputError, match="no bundled scenario has"):
                ground(given, lambda _, known: known[0])


def test_the_questions_are_asked_at_a_terminal(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [*COHAPTIC, "new", "mine.yaml"], cwd=tmp_path, stdin=theirs, stdout=theirs, stderr=theirs
    )
    os.close(theirs)
    os.write(ours, b"axis\n2\ncentralized\nlong\n5 s\n2\n3\n0\n0.5\n")
    said = b""
    try:
        while piece := os.read(ours, 4096):
            said += piece
    except OSError:  # the terminal's other end is closed
        pass
    os.close(ours)
    assert process.wait(20) == 0, said
    assert said.index(b"Motion") < said.index(b"Round trip") < said.index(b"Mass")
    assert b"'long' is not a number with a unit" in said, "and it is asked again"
    assert said.count(b"Duration") == said.count(b"Share of the packets") == 2, "3 is no share"
    scenario = load(tmp_path / "mine.yaml")
    assert (float(scenario.duration), set(scenario.channels)) == (5.0, {"lan"})


def test_without_a_terminal_nothing_is_asked(tmp_path: Path) -> None:
    done = cohaptic("new", "mine.yaml", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "cohaptic run mine.yaml" in done.stdout
    mine, bundled = load(tmp_path / "mine.yaml"), load("two_users_box")
    assert (mine.title, mine.duration) == ("mine", bundled.duration)
    assert mine.components.keys() == bundled.components.keys()
    options = ("--users", "1", "--duration", "1 min", "--mass", "0.7")
    assert cohaptic("new", "alone.yml", *options, folder=tmp_path).returncode == 0
    alone = load(tmp_path / "alone.yml")
    assert (float(alone.duration), alone.channels) == (60.0, {})
    wrong = cohaptic("new", "long.yaml", "--duration", "long", folder=tmp_path)
    assert (wrong.returncode, (tmp_path / "long.yaml").exists()) == (2, False)
    assert "'long' is not a number with a unit" in wrong.stderr
    lonely = cohaptic("new", "x.yaml", "--users", "1", "--loss", "0.1", folder=tmp_path)
    assert lonely.returncode == 2
    assert "a single user has none" in lonely.stderr


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("mine")
    done = cohaptic("new", "mine.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert (tmp_path / "mine.yaml").read_text() == "mine"


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes_scenarios_and_signals(tmp_path: Path) -> None:
    """Through bash itself: the script is sourced and its function called."""
    cohaptic("run", "single_user", "--no-figure", "--out", "mine", folder=tmp_path)

    def offered(*words: str) -> list[str]:
        line = " ".join(f"'{word}'" for word in ("cohaptic", *words))
        script = (
            'eval "$(cohaptic completion bash)"\n'
            f"COMP_WORDS=({line}); COMP_CWORD={len(words)}\n"
            "_cohaptic_completion cohaptic\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n"
        )
        done = subprocess.run(
            ["bash", "-c", script],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"},
        )
        return done.stdout.split()

    assert "thesis/four_users" in offered("run", "thesis/f")
    assert offered("plot", "mine", "hand_1.p") == ["hand_1.position"]
    assert offered("plot", "mi") == ["mine/"]
    assert offered("sc") == ["scenarios"]


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_ask_and_are_answered(shell: str, tmp_path: Path) -> None:
    """What their scripts send, as zsh and fish do; the shells themselves, where they are there."""
    cohaptic("run", "single_user", "--no-figure", "--out", "mine", folder=tmp_path)
    script = cohaptic("completion", shell, folder=tmp_path)
    assert script.returncode == 0
    assert f"_COHAPTIC_COMPLETE={shell}_complete" in script.stdout

    def answered(*words: str) -> str:
        asked = {"_COHAPTIC_COMPLETE": f"{shell}_complete"}
        asked["COMP_WORDS"] = " ".join(("cohaptic", *words)).strip()
        asked["COMP_CWORD"] = str(len(words)) if shell == "zsh" else words[-1]
        done = subprocess.run(
            [Path(sys.executable).with_name("cohaptic")],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, **asked},
        )
        return done.stdout

    assert "thesis/four_users" in answered("run", "thesis/f")
    assert "hand_1.position" in answered("plot", "mine", "hand_1.p")
    assert "hand_1.force" not in answered("plot", "mine", "hand_1.p")
    assert "mine/" in answered("compare", "mi")


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish; .ci/run has it")
def test_fish_completes(tmp_path: Path) -> None:
    script = 'cohaptic completion fish | source; complete -C "cohaptic run thesis/four"'
    assert "thesis/four_users" in in_shell(("fish", "--no-config", "-c"), script, tmp_path)


@pytest.mark.skipif(shutil.which("zsh") is None, reason="needs zsh; .ci/run has it")
def test_zsh_completes(tmp_path: Path) -> None:
    script = (
        "autoload -Uz compinit; compinit -u -D; "
        'eval "$(cohaptic completion zsh)"\n'
        'compadd() { print -rl -- "$@" } ; _describe() { print -rl -- ${(P)4:-} ${(P)3:-} }\n'
        "words=(cohaptic run thesis/four); CURRENT=3; _cohaptic_completion\n"
        "print -r -- registered ${_comps[cohaptic]}"
    )
    shown = in_shell(("zsh", "-f", "-c"), script, tmp_path)
    assert "thesis/four_users" in shown
    assert "registered _cohaptic_completion" in shown


def in_shell(shell: tuple[str, ...], script: str, folder: Path) -> str:
    done = subprocess.run(
        [*shell, script],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"},
    )
    return done.stdout
