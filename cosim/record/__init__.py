"""The run record: writing it while a run goes on, reading it, comparing it, exporting it.

``open_run(folder)`` reads one; ``digest(run)`` says whether two are equal, bit for bit.
"""

from __future__ import annotations

from cosim.record.digest import digest
from cosim.record.reader import Run, open_run
from cosim.record.signals import RecordedSignal

__all__ = ["RecordedSignal", "Run", "digest", "open_run"]
