"""A run as MCAP (mcap.dev), the container that robotics tools replay.

Each group is a topic whose messages are one row each (``cosim.base.foxglove.rows``).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from cosim.base.foxglove.entities import TOPIC
from cosim.base.foxglove.rows import CDR_LITTLE_ENDIAN, RowMessage
from cosim.base.foxglove.schema import NAME, scene_schema
from cosim.record.export.scene_updates import nanoseconds, scene_updates
from cosim.record.export.table import Table, needed
from cosim.record.export.texts import ChangeTable


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
    signals = table.signals
    message = RowMessage.of(table.name, [s.name for s in signals], [s.is_float for s in signals])
    schema = writer.register_schema(
        name=message.schema_name, encoding="ros2msg", data=message.definition.encode()
    )
    channel = writer.register_channel(topic=message.topic, message_encoding="cdr", schema_id=schema)
    writer.add_metadata(
        f"signals/{table.name}",
        {
            name: f"{signal.name} [{signal.unit or '1'}]"
            for name, signal in zip(message.fields, signals, strict=True)
        },
    )
    row = message.row
    for first, last in table.pieces():
        ticks = table.ticks(first, last)
        rows = np.empty(last - first, dtype=row)
        rows["tick"], rows["time"] = ticks, table.run.seconds(ticks)
        for name, signal in zip(message.fields, signals, strict=True):
            rows[name] = table.values(signal, first, last)
        for tick, record in zip(ticks.tolist(), rows, strict=True):
            at = nanoseconds(table.run, tick)
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
        at = nanoseconds(texts.run, tick)
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
            schema = writer.register_schema(name=NAME, encoding="jsonschema", data=scene_schema())
            channel = writer.register_channel(
                topic=TOPIC, message_encoding="json", schema_id=schema
            )
        at = nanoseconds(run, tick)
        writer.add_message(
            channel_id=channel,
            log_time=at,
            publish_time=at,
            data=json.dumps(message, separators=(",", ":")).encode(),
            sequence=number,
        )
