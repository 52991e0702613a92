"""Who answers in a study: somebody at the terminal or at a page, or one who is emulated."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from pathlib import Path

from cosim.base.errors import InputError
from cosim.cli.support.page import ANYWHERE
from cosim.study.plan import StudyPlan
from cosim.study.session import Respondent

Say = Callable[[str], None]


@contextmanager
def seated(
    study: StudyPlan,
    *,
    emulate: bool,
    web: bool,
    live_at: str | None,
    mailboxes: Mapping[str, Path],
    say: Say,
) -> Generator[tuple[Respondent, Say]]:
    """Who answers, and how a trial is announced to them.

    ``mailboxes`` are those of the users whose hands the page moves.

    Raises:
        InputError: there is no terminal, no place for a page, or nobody to emulate.
    """
    if emulate:
        yield _emulated(study), say
        return
    if not web:
        from cosim.cli.support.study.person import PersonAtTerminal

        yield PersonAtTerminal(), say
        return
    from cosim.cli.support.study.page import PersonAtPage
    from cosim.live.access import listening
    from cosim.live.process import ServerProcess

    title = study.form.title or study.name
    where, run = listening(live_at or ANYWHERE), str(os.getpid())
    with ServerProcess(where, run, mailboxes=mailboxes, study=title) as server:
        somebody = PersonAtPage(server, say)
        say(f"study at: {server.address()}")
        yield somebody, somebody.announce


def _emulated(study: StudyPlan) -> Respondent:
    from cosim.study.emulated import EmulatedParticipant

    form = study.form
    if form.emulated is None or form.staircase is None:
        raise InputError(f"{study.file}: --emulate needs 'emulated' in the plan.")
    return EmulatedParticipant(form.emulated, form.staircase.answer, form.seed)
