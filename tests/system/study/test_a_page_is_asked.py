"""The page of a study, spoken to by a program: sheets there, answers back, judged at the study."""

from __future__ import annotations

import json
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest

from cosim.base.errors import RunError
from cosim.cli.support.study.page import PersonAtPage
from cosim.live.process import ServerProcess
from cosim.study.form import QuestionForm
from cosim.study.questions import NASA_TLX
from tests.support.command import cohaptic
from tests.support.live.client import Page, ask, upgrade_headers

FELT = {"felt": QuestionForm(ask="Felt?"), "newtons": QuestionForm(ask="N?", kind="number")}


def sheet(page: Page) -> dict:
    """The next one with a button."""
    while True:
        told = json.loads(page.hear()[1])
        if told.get("type") == "sheet" and "button" in told:
            return told


def test_a_server_that_dies_ends_the_session():
    with ServerProcess(("127.0.0.1", 0), "nothing", study="A title") as server:
        server.address()
        somebody = PersonAtPage(server, lambda _: None)
        server._process.kill()
        for _ in range(2):
            with pytest.raises(RunError, match="gone"):
                somebody.rest(0)


def test_answers_are_asked_again_until_they_are_some_and_a_page_may_leave(monkeypatch):
    said: list[str] = []
    with ExitStack() as stack:
        server = ServerProcess(("127.0.0.1", 0), "nothing", study="A title")
        stack.enter_context(server)
        address = urlsplit(server.address())
        assert ask(address, "/socket", **upgrade_headers(address, "wrong"))[0] == 403
        page = Page(address)
        stack.callback(page.close)
        hear = server.hear
        answers = iter(
            [
                {"answers": {}},
                {"answers": {"felt": "maybe", "newtons": "2"}},
                {"answers": {"felt": "y", "newtons": "2", "other": "9"}},
                {"answers": dict.fromkeys(NASA_TLX, "33")},
                {"leave": True},
            ]
        )
        shown = []

        def answered():
            shown.append(sheet(page))
            page.say({"sheet": {"number": shown[-1]["number"], **next(answers)}})
            return hear()

        monkeypatch.setattr(server, "hear", answered)
        somebody = PersonAtPage(server, said.append)
        somebody.announce("Trial 1 of 2.")
        assert said == ["Trial 1 of 2."]
        assert somebody.answers(FELT, None) == {"felt": True, "newtons": 2.0}
        again = {each["name"]: each for each in shown[2]["questions"]}
        assert (again["felt"]["problem"], again["felt"]["given"]) == ("Answer y or n.", "maybe")
        assert (again["newtons"]["problem"], again["newtons"]["given"]) == ("", "2")
        with pytest.raises(RunError, match="the same command goes on"):
            somebody.answers(NASA_TLX, None)
        problems = {each["problem"] for each in shown[-1]["questions"]}
        assert problems == {"Answer a number from 0 to 100 in steps of 5."}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--web", "--emulate"), "leave out --web"),
        (("--live-at", "127.0.0.1:0"), "add --web"),
        (("--hands",), "--hands is for"),
        (("--hands", "--web", "--no-realtime"), "--hands is for"),
        (("--hands", "--web"), "nobody can take part in"),
        (("--web", "--live-at", "0.0.0.0:0"), "stands for every address"),
    ],
)
def test_options_that_do_not_fit_are_refused(words, expected, tmp_path):
    plan = {
        "study": 1,
        "scenario": "single_axis_distributed",
        "conditions": {"one": {}},
        "trials": 1,
    }
    (tmp_path / "plan.yaml").write_text(json.dumps(plan))
    done = cohaptic("study", "plan.yaml", "--participant", "P", *words, folder=tmp_path)
    assert done.returncode == 2
    assert expected in done.stderr
    assert not (tmp_path / "studies").exists()
