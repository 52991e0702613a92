"""A run's page is one file that loads nothing, holds every signal, and lets no text become code."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim.plot.page.bundle import bundle
from cosim.reading import load
from cosim.record.reader import open_run
from cosim.record.scene import read_scene
from cosim.report.page.contents import FULL, contents
from cosim.report.page.document import write_page
from cosim.report.page.pack import unpack
from cosim.report.summary import read_summary
from cosim.run import run_scenario

HOSTILE = '</script><img src=x onerror=alert(1)> & "quoted" <b>'


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page") / "run"
    sets = ["duration=2 s", "expect={}", f"title={json.dumps(HOSTILE)}"]
    run_scenario(load("two_users_box", (), sets), folder, figure=False, page=True)
    return folder


class Elements(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def test_nothing_is_loaded_and_no_text_is_code(run_folder: Path) -> None:
    text = (run_folder / "report.html").read_text(encoding="utf-8")
    elements = Elements(text).found
    assert not [tag for tag, _ in elements if tag in {"img", "iframe", "object", "embed", "b"}]
    loaded = [attrs for _, attrs in elements if "src" in attrs or "srcset" in attrs]
    links = [attrs["href"] for tag, attrs in elements if tag in {"link", "a"}]
    assert (loaded, links) == ([], ["data:,"])
    assert sum(tag == "script" for tag, _ in elements) == 2
    style = text[text.index("<style>") : text.index("</style>")]
    assert not re.search(r"url\(|@import", style)


def test_peers_that_are_not_there_have_no_energy(run_folder: Path) -> None:
    text = (run_folder / "report.html").read_text(encoding="utf-8")
    table = text[text.index('<h2 id="energies">') :]
    table = table[: table.index("</section>")]
    ports = re.findall(r"vr_[ab]\.[^<]*energy", table.replace("<wbr>", ""))
    assert ports == [
        f"vr_{own}.{port}"
        for own in "ab"
        for port in (
            *("finger_1.observed_energy", "finger_2.observed_energy"),
            *("peer_contact_1.finger_1_energy", "peer_contact_1.finger_2_energy"),
        )
    ]


def test_every_signal_is_in_it_with_its_extremes(run_folder: Path) -> None:
    with open_run(run_folder) as run:
        summaries = {name: signal.summary() for name, signal in run.signals.items()}
        found = contents(run, summaries, read_scene(run_folder))
        assert [signal["name"] for signal in found["signals"]] == list(run.signals)
        whole = [signal for signal in found["signals"] if "rows" in signal]
        assert len(whole) == FULL
        for signal in found["signals"]:
            recorded = run[signal["name"]].values.astype(np.float64)
            room = 1e-5 * np.ptp(recorded) + 1e-15 * np.abs(recorded).max()
            if "rows" in signal:
                shown = unpack(found["packed"][signal["rows"]])
                assert np.abs(shown - recorded).max() <= room
            else:
                low, high = (unpack(found["packed"][signal[end]]) for end in ("low", "high"))
                assert low.min() == pytest.approx(recorded.min(), abs=room)
                assert high.max() == pytest.approx(recorded.max(), abs=room)


MET = {
    "label": "",
    "target": "vr_a.box_pose.x max",
    "predicate": "below",
    "threshold": 1.0,
    "measured": 0.5,
    "unit": "m",
    "passed": True,
}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({}, "5 of 5 expectations met"),
        ({"message": "Ctrl-C ended it."}, "Ctrl-C ended it."),
        ({"runaways": ["a.b runs away"], "status": 1}, "1 signal ran away · 5 of 5"),
    ],
)
def test_the_head_says_how_it_ended_once(
    more: dict[str, Any], said: str, run_folder: Path, tmp_path: Path
) -> None:
    summary = read_summary(run_folder)
    assert summary is not None
    good = {"expectations": [MET] * 5, "failures": [], "status": 0, "message": ""}
    content = {**summary.content, **good, **more}
    with open_run(run_folder) as run:
        summaries = {name: signal.summary() for name, signal in run.signals.items()}
        write_page(run, tmp_path / "page.html", content, summaries)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    head = page[page.index("<header>") : page.index("</header>")]
    assert head.count(said) == 1
    assert head.count("expectations met") == said.count("of 5")


def test_a_name_may_be_broken_and_no_number_of_it(run_folder: Path) -> None:
    page = (run_folder / "report.html").read_text(encoding="utf-8")
    assert "vr_<wbr>a.<wbr>finger_1.<wbr>observed_<wbr>energy</th>" in page


def test_what_moves_has_its_poses(run_folder: Path) -> None:
    with open_run(run_folder) as run:
        scene = read_scene(run_folder)
        found = contents(run, {n: s.summary() for n, s in run.signals.items()}, scene)
        poses = {pose["name"]: pose for pose in found["poses"]}
        for box in scene["boxes"]:
            for name in box["pose"]:
                recorded = run[name].values[:: round(poses[name]["period"] * 1024)]
                shown = unpack(found["packed"][poses[name]["rows"]])
                assert shown == pytest.approx(recorded, abs=1e-6)


def test_equal_signals_are_packed_once(run_folder: Path) -> None:
    with open_run(run_folder) as run:
        found = contents(run, {n: s.summary() for n, s in run.signals.items()}, None)
    texts = [json.dumps(packed) for packed in found["packed"]]
    assert len(set(texts)) >= 0.9 * len(texts)
    assert len(texts) < len(found["signals"])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('import { a } from "./other.js";', "imports other.js, which does not stand before it"),
        ('import * as all from "./other.js";', "no import or export that is understood"),
        ("export default class {}", "no import or export that is understood"),
    ],
)
def test_a_module_that_is_not_understood_is_refused(
    text: str, sentence: str, tmp_path: Path
) -> None:
    module = tmp_path / "module.js"
    module.write_text(text)
    with pytest.raises(ValueError, match=re.escape(sentence)):
        bundle([module])


def test_a_run_without_anything_to_see_has_a_page(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run_scenario(load("single_user", (), ["record=[]"]), folder, figure=False, page=True)
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert '"signals":[]' in text
    assert not (folder / "scene.json").exists() or '"bodies"' in (folder / "scene.json").read_text()
