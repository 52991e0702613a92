"""The folder of a run, which is made when the first tick is due."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.recording import RecordGroup
from cosim.record.folder import new_folder
from cosim.record.manifest import write_manifest
from cosim.record.reader import RUN_FILE, SCENARIO_FILE
from cosim.record.writer import Recorder
from cosim.scenario import Scenario
from cosim.scenario.resolved import to_yaml


class FolderRecorder(Recorder):
    """Creates the run's folder when the first tick is due: bad input leaves nothing behind."""

    def __init__(
        self,
        scenario: Scenario,
        out: Path | None,
        manifest: dict[str, Any],
        began: float,
        tell: Callable[[Path], None] | None,
    ) -> None:
        """``began`` is when the start-up began (``perf_counter``, s); ``tell`` gets the folder."""
        super().__init__(Path(RUN_FILE), scenario.ticks, scenario.start_tick)
        self.folder: Path | None = None
        self.start_up_time = 0.0
        self._scenario, self._out, self._manifest, self._began = scenario, out, manifest, began
        self._tell = tell

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        """Make the folder, with what is known of the run, and begin the record in it."""
        self.folder = new_folder(self._scenario.name, self._out)
        self.path = self.folder / RUN_FILE
        try:
            self._write_scenario(self._scenario)
            write_manifest(self.folder, self._manifest)
        except OSError as error:
            raise self.refusal(error) from error
        super().begin(groups, base_rate)
        if self._tell is not None:
            self._tell(self.folder)
        self.start_up_time = time.perf_counter() - self._began

    def keep_scenario(self, scenario: Scenario) -> None:
        """What ran in the end, which differs from what began where something was turned by hand."""
        if self.folder is not None and scenario != self._scenario:
            self._write_scenario(scenario)

    def _write_scenario(self, scenario: Scenario) -> None:
        assert self.folder is not None
        (self.folder / SCENARIO_FILE).write_text(to_yaml(scenario), encoding="utf-8")
