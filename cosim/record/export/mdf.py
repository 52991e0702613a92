"""A run as ASAM MDF 4.10: a channel group for each rate, read by most measurement tools."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cosim.record.export.table import Table, needed
from cosim.record.export.texts import ChangeTable

VERSION = "4.10"


def write_mdf(tables: list[Table], texts: list[ChangeTable], folder: Path) -> list[Path]:
    """``run.mf4``: the master channel is the time (s), ``tick`` the base tick as an integer.

    Raises:
        InputError: asammdf is not installed.
    """
    mdf = needed("mf4", "asammdf")
    path = folder / "run.mf4"
    with mdf.MDF(version=VERSION) as file:
        for index, table in enumerate(tables):
            for first, last in table.pieces():
                ticks = table.ticks(first, last)
                time = table.run.seconds(ticks)
                if first:
                    columns = [table.values(signal, first, last) for signal in table.signals]
                    file.extend(index, [(column, None) for column in (time, ticks, *columns)])
                else:
                    file.append(
                        _channels(mdf.Signal, table, last),
                        acq_name=table.name,
                        comment=f"base rate {table.run.base_rate} Hz, period {table.period} ticks",
                        common_timebase=True,
                    )
        for text in texts:
            file.append(_text_channels(mdf.Signal, text), acq_name=text.name, common_timebase=True)
        file.save(path, overwrite=True, compression=1)
    return [path]


def _text_channels(make: Any, texts: ChangeTable) -> list[Any]:
    """MDF keeps texts in fields of one length, filled up with zeros."""
    ticks = texts.ticks
    time = texts.run.seconds(ticks)
    columns = {"signal": texts.signals, "value": texts.values}
    return [
        make(ticks, time, name="tick", unit="1", comment="base tick"),
        *(
            make(np.array([each.encode() for each in column]), time, name=name, encoding="utf-8")
            for name, column in columns.items()
        ),
    ]


def _channels(make: Any, table: Table, rows: int) -> list[Any]:
    ticks = table.ticks(0, rows)
    time = table.run.seconds(ticks)
    return [
        make(ticks, time, name="tick", unit="1", comment="base tick"),
        *(
            make(
                table.values(signal, 0, rows),
                time,
                name=signal.name,
                unit=signal.unit or "1",
                comment=signal.description,
            )
            for signal in table.signals
        ),
    ]
