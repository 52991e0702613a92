"""A run as MCAP (mcap.dev), the container that robotics tools replay.

Each group is a topic whose messages are one row each, in the ROS 2 encoding: CDR, little-endian,
every field of eight bytes, so a row is a record of a NumPy array behind the four bytes that name
the encoding (OMG DDS-RTPS 2.5, section 10.5).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from cosim.record.export.scene_entities import SCHEMA, TOPIC, json_schema, scene_updates
from cosim.record.export.table import Table, needed
from cosim.record.export.texts import ChangeTable
from cosim.record.reader import Run

CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
NANOSECONDS = 1_000_000_000


def write_mcap(tables: list[Table], texts: list[ChangeTable], folder: Path) -> list[Path]:
    """``run.mcap``: a topic for each group, log times in simulated ns; texts as JSON messages.

    Where the run left a scene, ``/scene`` shows it in Foxglove's 3D panel.

    The metadata record ``signals/GROUP`` holds the original name and unit of each field.

    Raises:
        InputError: mcap is not installed.
    """
    writers = needed("mcap", "mcap.writer")
    path = folder / "run.mcap"
    with path.open("wb") as stream:
        writer = writers.Writer(stream)
        writer.start(profile="ros2", library="cohaptic")
        for table in tables:
            _write_topic(writer, table)
        for text in texts:
            _write_texts(writer, text)
        if tables:
            _write_scene(writer, tables)
        writer.finish()
    return [path]


def _write_topic(writer: Any, table: Table) -> None:
    names = ros_names([signal.name for signal in table.signals])
    kinds = ["float64" if signal.is_float else "int64" for signal in table.signals]
    fields = [("tick", "int64"), ("time", "float64"), *zip(names, kinds, strict=True)]
    schema = writer.register_schema(
        name=f"cohaptic/msg/{table.name.title().replace('_', '')}",
        encoding="ros2msg",
        data="".join(f"{kind} {name}\n" for name, kind in fields).encode(),
    )
    channel = writer.register_channel(
        topic=f"/{table.name}", message_encoding="cdr", schema_id=schema
    )
    writer.add_metadata(
        f"signals/{table.name}",
        {
            name: f"{signal.name} [{signal.unit or '1'}]"
            for name, signal in zip(names, table.signals, strict=True)
        },
    )
    row = np.dtype([(name, "<f8" if kind == "float64" else "<i8") for name, kind in fields])
    for first, last in table.pieces():
        ticks = table.ticks(first, last)
        rows = np.empty(last - first, dtype=row)
        rows["tick"], rows["time"] = ticks, table.run.seconds(ticks)
        for name, signal in zip(names, table.signals, strict=True):
            rows[name] = table.values(signal, first, last)
        for tick, record in zip(ticks.tolist(), rows, strict=True):
            at = _nanoseconds(table.run, tick)
            writer.add_message(
                channel_id=channel,
                log_time=at,
                publish_time=at,
                data=CDR_LITTLE_ENDIAN + record.tobytes(),
                sequence=tick // table.period,
            )


def _write_texts(writer: Any, texts: ChangeTable) -> None:
    schema = writer.register_schema(
        name="cohaptic/text",
        encoding="jsonschema",
        data=json.dumps(
            {
                "type": "object",
                "properties": {
                    "tick": {"type": "integer"},
                    "signal": {"type": "string"},
                    "value": {"type": "string"},
                },
            }
        ).encode(),
    )
    channel = writer.register_channel(
        topic=f"/{texts.name}", message_encoding="json", schema_id=schema
    )
    for number, (tick, signal, value) in enumerate(texts.rows):
        at = _nanoseconds(texts.run, tick)
        message = {"tick": tick, "signal": signal, "value": value}
        writer.add_message(
            channel_id=channel,
            log_time=at,
            publish_time=at,
            data=json.dumps(message).encode(),
            sequence=number,
        )


def _write_scene(writer: Any, tables: list[Table]) -> None:
    """What of the scene is exported, over the time that is exported."""
    run = tables[0].run
    names = {signal.name for table in tables for signal in table.signals}
    first = min(int(table.ticks(0, 1)[0]) for table in tables)
    last = max(int(table.ticks(table.rows - 1, table.rows)[0]) for table in tables) + 1
    channel: int | None = None
    for number, (tick, message) in enumerate(scene_updates(run, names, first, last)):
        if channel is None:
            schema = writer.register_schema(name=SCHEMA, encoding="jsonschema", data=json_schema())
            channel = writer.register_channel(
                topic=TOPIC, message_encoding="json", schema_id=schema
            )
        at = _nanoseconds(run, tick)
        writer.add_message(
            channel_id=channel,
            log_time=at,
            publish_time=at,
            data=json.dumps(message, separators=(",", ":")).encode(),
            sequence=number,
        )


def _nanoseconds(run: Run, tick: int) -> int:
    rate = run.base_rate
    return (tick + run.start_tick) * rate.denominator * NANOSECONDS // rate.numerator


def ros_names(names: list[str]) -> list[str]:
    """Field names of ROS 2: ``vr_a.finger_1.force[2]`` becomes ``vr_a_finger_1_force_2``.

    Lower case, single underscores, a letter first; equal ones end in a number.
    """
    found: list[str] = []
    taken = {"tick", "time"}
    for name in names:
        plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
        plain = plain if plain[:1].isalpha() else f"x_{plain}".rstrip("_")
        unique, number = plain, 1
        while unique in taken:
            number += 1
            unique = f"{plain}_{number}"
        taken.add(unique)
        found.append(unique)
    return found
