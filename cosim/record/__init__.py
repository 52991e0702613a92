"""The run record: writing it while a run goes on, reading it, comparing it, exporting it.

``open_run(folder)`` reads one; ``digest(run)`` says whether two are equal, bit for bit.
"""

from __future__ import annotations

from cosim.record.digest import digest
from cosim.record.reader import RecordedSignal, Run, open_run

__all__ = ["RecordedSignal", "Run", "digest", "open_run"]
