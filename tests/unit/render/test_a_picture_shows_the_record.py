"""A frame has the box and the fingers where the record has them; a film has the time of the run."""

from __future__ import annotations

import itertools
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.cli.render import FILMS
from cosim.reading import load
from cosim.record.reader import open_run
from cosim.record.scene import read_scene
from cosim.render.colours import colours, mixed
from cosim.render.film import FORMATS, WRITERS
from cosim.render.picture import OVERSAMPLED, Painter
from cosim.render.poses import Poses, frame_ticks, read_poses
from cosim.render.view import view_of
from cosim.run import run_scenario

SIZE = (320, 240)


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("render") / "run"
    sets = ["duration=4 s", "expect={}"]
    run_scenario(load("two_users_box", (), sets), folder, figure=False)
    return folder


def render(*arguments: object) -> str:
    words = ["render", *map(str, arguments)]
    return CliRunner().invoke(cli, words, catch_exceptions=False, standalone_mode=False).output


def middle(image: Any, colour: tuple[int, int, int]) -> tuple[float, float]:
    """Mean place (pixels) of what has a colour."""
    pixels = np.asarray(image, np.int64)
    y, x = np.nonzero(np.abs(pixels - colour).max(axis=2) <= 2)
    assert x.size
    return float(x.mean()), float(y.mean())


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_box_stands_where_the_record_has_it(run_folder: Path, scheme: str) -> None:
    with open_run(run_folder) as run:
        scene = read_scene(run_folder)
        assert scene is not None
        scene |= {"fingers": []}  # nothing lies over the box
        poses = read_poses(run, scene, [0, 1024, 3000, 4095])
    painter = Painter(scene, poses, SIZE, scheme=scheme)
    view = view_of(scene, poses, SIZE)
    chosen = colours(scheme)
    fill = mixed(chosen["user-0"], chosen["ground"], 0.16)
    found = [middle(painter.frame(number), fill) for number in range(4)]
    for number, place in enumerate(found):
        at = view.at([float(poses.values[name][number]) for name in scene["boxes"][0]["pose"][:2]])
        assert place == pytest.approx(at, abs=1.5)
    assert abs(found[3][1] - found[0][1]) > 10, "the box was carried"


def test_every_finger_is_in_the_picture(run_folder: Path) -> None:
    with open_run(run_folder) as run:
        scene = read_scene(run_folder)
        assert scene is not None
        poses = read_poses(run, scene, [2048])
    image = np.asarray(Painter(scene, poses, SIZE).frame(0), np.int64)
    view = view_of(scene, poses, SIZE)
    for finger in scene["fingers"]:
        x, y = view.at([float(poses.values[name][0]) for name in finger["position"]])
        colour = colours()["user-0" if finger["station"] == "station_a" else "user-1"]
        assert np.abs(image[round(y), round(x)] - colour).max() <= 2


def test_what_has_no_place_is_left_out_and_the_rest_is_drawn(run_folder: Path) -> None:
    """Of a device some signals are NaN; where all are, a picture of nothing is one, too."""
    with open_run(run_folder) as run:
        scene = read_scene(run_folder)
        assert scene is not None
        poses = read_poses(run, scene, [2048])
    whole = np.asarray(Painter(scene, poses, SIZE).frame(0))
    nowhere = Poses(poses.times, {name: np.full(1, np.nan) for name in poses.values})
    empty = np.asarray(Painter(scene, nowhere, SIZE).frame(0))
    assert empty.shape == whole.shape
    for name in poses.values:
        some = Poses(poses.times, {**poses.values, name: np.full(1, np.nan)})
        assert Painter(scene, some, SIZE).frame(0).size == SIZE, name


def test_values_are_those_of_the_tick_before_each_frame(run_folder: Path) -> None:
    with open_run(run_folder) as run:
        scene = read_scene(run_folder)
        assert scene is not None
        ticks = frame_ticks(run, Fraction(1), Fraction(2), Fraction(1, 30))
        poses = read_poses(run, scene, ticks)
        assert len(ticks) == 31
        for name, values in poses.values.items():
            signal = run[name]
            assert values.tolist() == [signal.values[tick // signal.group.period] for tick in ticks]


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_a_film_lasts_as_long_as_what_it_shows(
    run_folder: Path, suffix: str, tmp_path: Path
) -> None:
    out = tmp_path / f"film{suffix}"
    render(run_folder, "--out", out, "--from", "1 s", "--until", "2.5 s", "--size", *SIZE)
    with Image.open(out) as film:
        assert film.size == SIZE
        lengths = []
        for number in range(film.n_frames):
            film.seek(number)
            film.load()
            lengths.append(film.info["duration"])
    assert sum(lengths) == pytest.approx(1500, abs=41)
    first = out.read_bytes()
    render(run_folder, "--out", out, "--from", "1 s", "--until", "2.5 s", "--size", *SIZE)
    assert out.read_bytes() == first


def test_speed_is_simulated_seconds_a_second(run_folder: Path, tmp_path: Path) -> None:
    said = render(
        run_folder,
        "--out",
        tmp_path / "x.gif",
        "--speed",
        "0.1",
        "--until",
        "0.2 s",
        "--size",
        160,
        120,
    )
    assert "51 pictures, 2.04 s" in said


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--from", "9 s"], "from 9 s to 4 s there is nothing"),
        (["--speed", "0.001", "--frames", "60"], "pictures are too many"),
    ],
)
def test_what_cannot_be_drawn_is_refused(
    run_folder: Path, arguments: list[str], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=sentence):
        render(run_folder, "--out", tmp_path / "film.gif", *arguments)
    assert not (tmp_path / "film.gif").exists()


def test_a_run_without_a_scene_says_so(tmp_path: Path) -> None:
    run_scenario(load("single_user", (), ["record=[step_1.value]"]), tmp_path / "r", figure=False)
    (tmp_path / "r" / "scene.json").unlink(missing_ok=True)
    with pytest.raises(InputError, match="Run its scenario again"):
        render(tmp_path / "r", "--out", tmp_path / "film.gif")


def test_an_mp4_has_every_frame(run_folder: Path, tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    out = tmp_path / "film.mp4"
    render(run_folder, "--out", out, "--until", "2 s", "--size", *SIZE)
    with av.open(str(out)) as film:
        frames = list(film.decode(video=0))
    assert (len(frames), frames[0].width, frames[0].height) == (51, *SIZE)


def test_the_sides_of_an_mp4_are_even(run_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="even numbers"):
        render(run_folder, "--out", tmp_path / "film.mp4", "--size", 321, 240)


def test_the_command_knows_every_format() -> None:
    assert set(FILMS) == set(FORMATS) == set(WRITERS)
    assert OVERSAMPLED >= 2


@pytest.mark.parametrize("metres", [0.01, 3.0, 200.0])
def test_bodies_stand_below_one_another_however_far_they_drift(metres: float) -> None:
    """A view of many metres has few pixels for each, and the bodies still have a row each."""
    names = [f"body_{number}" for number in range(4)]
    bodies = [{"name": "", "position": name} for name in names]
    scene = {kind: [] for kind in ("boxes", "fingers", "walls", "pointers", "channels")}
    scene |= {"bodies": bodies}
    poses = Poses(np.arange(2.0), {name: np.array([0.0, metres]) for name in names})
    picture = np.asarray(Painter(scene, poses, SIZE, scheme="light").frame(0), np.int64)
    rows: list[np.ndarray] = []
    for number in range(4):
        colour = colours("light")[f"user-{number}"]
        rows.append(np.nonzero((np.abs(picture - colour).max(axis=2) <= 2).any(axis=1))[0])
        assert rows[-1].size >= 14, "a body is 18 pixels high, its edges softened"
    for above, below in itertools.pairwise(rows):
        assert above.max() < below.min()
