"""An FMU, packed or unpacked, runs without a scenario; one of one's own is made anywhere."""

from __future__ import annotations

import json
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner

import fmus
from cosim.base.errors import CohapticError
from cosim.cli import cli
from cosim.record.reader import open_run
from tests.support.fmus.foreign import foreign_fmu, scalar


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@dataclass(frozen=True)
class Done:
    exit_code: int
    output: str
    stdout: str


def cohaptic(*arguments: str) -> Done:
    done = CliRunner().invoke(cli, list(arguments))
    if isinstance(done.exception, CohapticError):
        return Done(done.exception.exit_status, str(done.exception), done.stdout)
    return Done(done.exit_code, done.output, done.stdout)


def unpacked(fmu: Path, folder: Path) -> Path:
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    return folder


def run_alone(here: Path, given: Path, *more: str) -> Done:
    return cohaptic("run", str(given), "--out", str(here / "out"), "--no-figure", *more)


def test_a_file_and_a_folder_run_for_as_long_as_is_said(here: Path) -> None:
    found = []
    given = fmus.find("hand")
    for number, fmu in enumerate((given, unpacked(given, here / "folder"))):
        out = here / f"out{number}"
        done = cohaptic(
            *("run", str(fmu), "--out", str(out), "--no-figure", "--stop-time", "0.5"),
            *("--step-size", "10 ms", "--set", "mass=2 kg", "--set", "force=3"),
        )
        assert done.exit_code == 0, done.output
        with open_run(out) as run:
            assert run.ticks == 50
            name = next(n for n in run.signals if n.endswith(".velocity"))
            found.append(run[name].values[-1])
    assert found[0] == found[1] == pytest.approx(49 * 0.01 * 3 / 2)


def test_without_options_the_default_experiment_says_how_long(here: Path) -> None:
    experiment = '<DefaultExperiment stopTime="0.25" stepSize="0.125"/>'
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input", start="0"), before=experiment)
    assert run_alone(here, fmu).exit_code == 0
    with open_run(here / "out") as run:
        assert run.ticks == 2


@pytest.mark.parametrize(
    ("experiment", "more", "times"),
    [
        ('startTime="1.5" stopTime="2" stepSize="0.125"', (), (1.5, 2.0)),
        ('startTime="1.5" stopTime="2" stepSize="0.125"', ("--stop-time", "3"), (1.5, 3.0)),
        ('startTime="1.5" stopTime="2"', (), (1.5, 2.0)),
        ('startTime="0.7" stopTime="4.3"', (), (0.7, 4.3)),
        ('startTime="-1" stopTime="1" stepSize="0.125"', ("--set", "start_time=0"), (0.0, 1.0)),
        ('stopTime="2"', ("--set", "start_time = 500 ms"), (0.5, 2.0)),
    ],
)
def test_it_begins_where_the_default_experiment_says(
    here: Path, experiment: str, more: tuple[str, ...], times: tuple[float, float]
) -> None:
    """The FMU is told so, too."""
    snippet = """
        static int hook(Foreign *m, const char *call)
        {
            if (is(call, "DoStep"))
                m->real[1] = m->time;
            return 0;
        }
        #define HOOK hook
    """
    fmu = foreign_fmu(
        here,
        3,
        scalar(3, "begun", 1, causality="output"),
        before=f"<DefaultExperiment {experiment}/>",
        structure='<Output valueReference="1" dependencies=""/>',
        snippet=snippet,
    )
    done = run_alone(here, fmu, *more)
    assert done.exit_code == 0, done.output
    with open_run(here / "out") as run:
        assert run.span == pytest.approx(times)
        assert run["foreign.begun"].values[1] == pytest.approx(times[0])


@pytest.mark.parametrize(
    ("times", "end"),
    [
        (("1", "0.25"), 1.0),
        (("0.3333333333333333", None), 1 / 3),  # written for a third
        (("1", "0.0033333333333333335"), 1.0),
        (("1", "0.3"), 1.2),
    ],
)
def test_times_are_what_was_meant(here: Path, times: tuple[str, str | None], end: float) -> None:
    """Beyond the end is run only where no whole number of steps fits, and then that is said."""
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input", start="0"))
    stop, step = times
    more = () if step is None else ("--step-size", step)
    done = run_alone(here, fmu, "--stop-time", stop, *more)
    assert done.exit_code == 0, done.output
    with open_run(here / "out") as run:
        assert run.span == pytest.approx((0.0, end))
    assert ("no whole number of steps" in done.output) == (end > 1)


def test_a_step_longer_than_the_run_is_refused(here: Path) -> None:
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input", start="0"))
    done = run_alone(here, fmu, "--stop-time", "1", "--step-size", "2")
    assert (done.exit_code, "longer than the 1 s that" in done.output) == (2, True)


NAMES = ("a b", "p[Color.red]", "größe", "a..b", "a=b", "a:b", "true", "-a", "{q}", "duration")


@pytest.mark.parametrize("name", NAMES)
def test_a_variable_is_set_by_whatever_name_it_has(here: Path, name: str) -> None:
    values = "".join(
        scalar(3, each, 1 + i, causality="parameter", variability="fixed", start="0")
        + scalar(3, f"out {each}", 1 + i, causality="output", start="0", initial="exact")
        for i, each in enumerate(NAMES)
    )
    structure = "".join(f'<Output valueReference="{1 + i}"/>' for i in range(len(NAMES)))
    fmu = foreign_fmu(here, 3, values, structure=structure)
    done = run_alone(here, fmu, "--stop-time", "1", "--set", f"{name} = 7")
    assert done.exit_code == 0, done.output
    with open_run(here / "out") as run:
        found = {each: run[f"foreign.out {each}"].values[-1] for each in NAMES}
    assert found == dict.fromkeys(NAMES, 0) | {name: 7}


@pytest.mark.parametrize("name", ["ü.fmu", "Über alles (1).fmu", "7.fmu", "a-b.FMU"])
def test_an_fmu_runs_whatever_its_file_is_called(here: Path, name: str) -> None:
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input", start="0")).rename(name)
    done = run_alone(here, fmu, "--stop-time", "1")
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("lenght=3", "has no variable 'lenght'. Did you mean length?"),
        ("duratoin=3", "has no variable 'duratoin'. Did you mean duration?"),
        ("x[2]=3", "foreign.x is an array (3); give the whole of it"),
        ("length=3 s", "--set length=3 s: foreign.length is a number: '3 s' is in s, which does"),
    ],
)
def test_an_override_that_leads_nowhere_names_the_nearest(
    here: Path, given: str, said: str
) -> None:
    values = scalar(3, "length", 1, causality="parameter", variability="fixed", start="0")
    values += scalar(
        3,
        *("x", 2, "Float64", '<Dimension start="3"/>'),
        causality="parameter",
        variability="fixed",
        start="1 2 3",
    )
    fmu = foreign_fmu(here, 3, values)
    done = run_alone(here, fmu, "--stop-time", "1", "--set", given)
    assert (done.exit_code, said in done.output) == (2, True), done.output


def test_what_is_missing_or_for_scenarios_is_said(here: Path) -> None:
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input", start="0"))
    done = run_alone(here, fmu)
    assert done.exit_code == 2
    assert "does not say how long to run; give --stop-time" in done.output
    assert "--stop-time: " in run_alone(here, fmu, "--stop-time", "soon").output
    done = run_alone(here, fmu, "--stop-time", "1", "--set", "v=3")
    assert done.exit_code == 2
    assert "there is no FMU at" in cohaptic("run", "none.fmu", "--stop-time", "1").output
    for option in ("--stop-time", "--step-size"):
        done = cohaptic("run", "single_user", option, "1", "--no-figure")
        assert done.exit_code == 2
        assert "are for an FMU in place of a scenario" in done.output
    done = run_alone(here, fmu, "--duration", "1")
    assert done.exit_code == 2


def test_validate_says_what_is_broken_and_whether_it_starts(here: Path) -> None:
    good = cohaptic("fmu", "validate", "object")
    assert (good.exit_code, "starts and ends" in good.output) == (0, True)
    snippet = """
        static int hook(Foreign *m, const char *call)
        {
            return is(call, "EnterInitializationMode") ? 3 : 0;
        }
        #define HOOK hook
    """
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input"), snippet=snippet, name="bad")
    bad = cohaptic("fmu", "validate", str(fmu), "--json")
    found = json.loads(bad.stdout)
    assert bad.exit_code == 1
    assert (found["ok"], found["starts"], len(found["breaks"])) == (False, False, 1)
    assert "refused to enter initialisation mode" in found["failure"]
    (here / "no.fmu").write_bytes(b"no")
    assert cohaptic("fmu", "validate", "no.fmu").exit_code == 2


def test_a_model_of_ones_own_is_made_outside_of_a_checkout(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fmus, "is_checkout", lambda: False)
    assert cohaptic("fmu", "new", "models/ball").exit_code == 0
    built = cohaptic("fmu", "build", "models/ball", "--out", "made")
    assert built.exit_code == 0, built.output
    assert run_alone(here, here / "made" / "ball.fmi2.fmu", "--stop-time", "1").exit_code == 0
    assert cohaptic("fmu", "validate", "made/ball.fmi3-arrays.fmu").exit_code == 0
    refused = cohaptic("fmu", "build")
    assert (refused.exit_code, "in a checkout" in refused.output) == (2, True)


@pytest.mark.parametrize(
    ("name", "said"), [("Ball", "cannot name a model"), ("there", "is there and not empty")]
)
def test_a_model_is_not_written_over_anything(here: Path, name: str, said: str) -> None:
    (here / "there").mkdir()
    (here / "there" / "file").touch()
    done = cohaptic("fmu", "new", name)
    assert done.exit_code == 2
    assert said in done.output


@pytest.mark.parametrize(
    ("text", "said"),
    [("1 +", "cannot be read: SyntaxError"), ("x = 1", "has no MODEL"), (None, "no variables.py")],
)
def test_a_folder_without_a_model_is_a_sentence(here: Path, text: str | None, said: str) -> None:
    (here / "mine").mkdir()
    if text is not None:
        (here / "mine" / "variables.py").write_text(text)
    done = cohaptic("fmu", "build", "./mine")
    assert done.exit_code == 2
    assert said in done.output


@pytest.mark.skipif(sys.platform == "win32", reason="the start is tried in a fork")
def test_an_fmu_that_ends_its_process_is_told_with_its_own_status(
    here: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Once, and by the command."""
    snippet = """
        void exit(int);
        static int hook(Foreign *m, const char *call)
        {
            if (is(call, "EnterInitializationMode"))
                exit(0);
            return 0;
        }
        #define HOOK hook
    """
    fmu = foreign_fmu(here, 3, scalar(3, "u", 1, causality="input", start="0"), snippet=snippet)
    found = json.loads(cohaptic("fmu", "validate", str(fmu), "--json").stdout)
    assert "foreign ended the process (exit status 0)" in found["failure"]
    assert "ended this process" not in capfd.readouterr().err
