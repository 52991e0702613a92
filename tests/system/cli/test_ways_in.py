"""What a newcomer meets first: the list of scenarios, a starter of one's own, completion."""

from __future__ import annotations

import itertools
import json
import os
import pty
import shutil
import subprocess
import sys
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
    os.write(ours, b"axis\n2\ncentralized\n5 s\n2\n0\n0.5\n")
    said = b""
    try:
        while piece := os.read(ours, 4096):
            said += piece
    except OSError:  # the terminal's other end is closed
        pass
    os.close(ours)
    assert process.wait(20) == 0, said
    assert said.index(b"Motion") < said.index(b"Round trip") < said.index(b"Mass")
    scenario = load(tmp_path / "mine.yaml")
    assert (float(scenario.duration), set(scenario.channels)) == (5.0, {"lan"})


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
def test_other_shells_have_a_script(shell: str, tmp_path: Path) -> None:
    done = cohaptic("completion", shell, folder=tmp_path)
    assert done.returncode == 0
    assert "_COHAPTIC_COMPLETE" in done.stdout
