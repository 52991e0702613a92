"""Runs the trials of a study: the condition's scenario with the trial's value and seed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.cli.support.run.one import RunOptions, read_one, run_one
from cosim.study.plan import StudyPlan, condition_sets
from cosim.study.session import StudyTrial
from cosim.study.staircase import tried
from cosim.sweep.planning.places import expand

if TYPE_CHECKING:
    from cosim.cli.support.study.hands import ParticipantHands
    from cosim.scenario.load import Written


class TrialRunner:
    """Paced, where somebody sits there; a record for each trial."""

    def __init__(
        self,
        plan: StudyPlan,
        options: RunOptions,
        say: Callable[[str], None],
        hands: ParticipantHands | None = None,
    ) -> None:
        """Read every condition's scenario once, so that what is wrong is said before anybody waits.

        ``hands`` are those of participants who move them on a page.

        Raises:
            InputError: a scenario, a place or a value cannot be used.
        """
        self._plan, self._base, self._say, self._hands = plan, options, say, hands
        self._places = {name: self._expanded(name) for name in plan.form.conditions}
        for name in plan.form.conditions:
            rule = plan.form.staircase
            for value in (None,) if rule is None else tried(rule):
                self._read(StudyTrial(1, name, 1, value, 0))

    def __call__(self, trial: StudyTrial, folder: Path) -> Mapping[str, Any]:
        """The content of the trial's summary.

        Raises:
            InputError, RunError: as ``cohaptic run``.
        """
        scenario, options = self._read(trial)
        instances = None if self._hands is None else self._hands.instances(scenario)
        return run_one(scenario, folder, options, self._say, instances).summary.content

    def _read(self, trial: StudyTrial) -> tuple[Any, RunOptions]:
        sets = (*condition_sets(self._plan, trial.condition), *self._own(trial))
        options = replace(self._base, sets=sets)
        file = self._plan.scenario_of(trial.condition)
        scenario = read_one(str(file), options, self._say)
        if self._hands is not None:
            scenario = self._hands.taken_over(scenario, file, sets)
        return scenario, options

    def _own(self, trial: StudyTrial) -> list[str]:
        unit = self._plan.form.staircase.unit if self._plan.form.staircase else ""
        value = "" if trial.value is None else f"{_written(trial.value)} {unit}".rstrip()
        places = self._places[trial.condition] if value else ()
        return [*(f"{place}={value}" for place in places), f"seed={trial.seed}"]

    def _expanded(self, condition: str) -> tuple[str, ...]:
        """Where the staircase's value goes, as paths of ``--set``."""
        from cosim.reading import FORMS
        from cosim.scenario.load import read

        rule = self._plan.form.staircase
        if rule is None:
            return ()
        sets = condition_sets(self._plan, condition)
        written: Written = read(self._plan.scenario_of(condition), (), sets, forms=FORMS)
        places = [rule.vary] if isinstance(rule.vary, str) else rule.vary
        return tuple(path for place in places for path in expand(written.root, place))


def _written(value: float) -> str:
    """All of it, and a whole number as one, which is what some places take."""
    return repr(value).removesuffix(".0")
