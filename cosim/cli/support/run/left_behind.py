"""What is left of a run whose process has ended, however that came: its record, and a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from cosim.base.errors import RunError
from cosim.master.run.obituary import COMPLETE, KEPT, NOTHING, obituary
from cosim.master.run.whereabouts import Whereabouts
from cosim.record.manifest import conclude, write_json, write_manifest
from cosim.record.reader import RUN_FILE, open_run
from cosim.record.rewriting.compact import compact
from cosim.report.summary import SUMMARY_FILE, Summary, summarise
from cosim.report.verdict.reading import parse_expectations
from cosim.run import LOG_FILE, Finished, write_log
from cosim.scenario import Scenario


def conclude_run(
    told: Mapping[str, Any], status: int, whereabouts: Whereabouts, scenario: Scenario
) -> Finished:
    """The run of a child that has ended with ``status``; ``told`` is the last of each that it said.

    Raises:
        CohapticError: the child said so, or died before there was a record.
        KeyboardInterrupt: it was interrupted before there was anything to keep.
    """
    if "error" in told:
        raise told["error"]
    if "interrupted" in told:
        raise KeyboardInterrupt
    if "bug" in told:
        raise RuntimeError(f"in the run's process:\n{told['bug']}")
    if "over" in told and status == 0:
        return told["finished"]
    sentence = obituary(status, whereabouts, scenario, told.get("left"))
    return _conclude(told, sentence, whereabouts, scenario)


def give_up(told: Mapping[str, Any], whereabouts: Whereabouts, scenario: Scenario) -> Finished:
    """The run of a child that was ended because it did not come back.

    Raises:
        RunError: there is no record.
    """
    component, doing = whereabouts.sentence(scenario)
    reason = whereabouts.log(component, scenario).reason()
    sentence = f"{component or 'the run'} did not come back {doing}, so that Ctrl-C ended it"
    return _conclude(told, f"{sentence}{reason}", whereabouts, scenario)


def _conclude(
    told: Mapping[str, Any], sentence: str, whereabouts: Whereabouts, scenario: Scenario
) -> Finished:
    if "begun" not in told:
        raise RunError(f"{sentence}; {NOTHING}.")
    kept = COMPLETE if "finished" in told else KEPT
    return _finish_for(told["begun"], scenario, f"{sentence}; {kept}.", whereabouts)


def _keep_logs(folder: Path, whereabouts: Whereabouts, scenario: Scenario) -> None:
    """What FMUs had logged when their process died, where the run has not written it itself."""
    said = whereabouts.said(scenario)
    if said and not (folder / LOG_FILE).exists():
        write_log(folder / LOG_FILE, said)


def _finish_for(
    folder: Path, scenario: Scenario, message: str, whereabouts: Whereabouts
) -> Finished:
    """Finish the record in ``folder`` of a run whose process has died, and say so in it.

    What was flushed before is there; what had been finished stays, but the run has failed.
    """
    with suppress(OSError):
        compact(folder / RUN_FILE)
    with suppress(OSError):
        _keep_logs(folder, whereabouts, scenario)
    with open_run(folder) as run:
        manifest = dict(run.manifest)
        if manifest.get("exit") is None:
            conclude(manifest, status=1, message=message, ticks=whereabouts.kernel.tick)
        else:
            manifest["exit"] = {**manifest["exit"], "status": 1, "message": message}
        write_manifest(folder, manifest)
        run.manifest = manifest
        content = dict(summarise(run, parse_expectations(scenario, run.record_groups)).content)
    write_json(folder / SUMMARY_FILE, content)
    return Finished(folder, Summary(content), RunError(message))
