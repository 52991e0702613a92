"""Writing device files: what is not measured stays as it was written, comments included."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from difflib import unified_diff
from io import StringIO
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from hil.device.contract import WatchdogProof
from hil.setup.device_file import load, parse
from hil.setup.driver_facts import DriverFacts

Pair = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Edit:
    """A device file before and after."""

    path: Path
    before: str
    after: str

    @property
    def difference(self) -> str:
        """Line by line; empty where nothing changes."""
        lines = unified_diff(
            self.before.splitlines(keepends=True),
            self.after.splitlines(keepends=True),
            str(self.path),
            f"{self.path}, calibrated",
        )
        return "".join(lines)

    def write(self) -> None:
        """Put it in place."""
        with writing(self.path), self.path.open("w", encoding="utf-8") as stream:
            stream.write(self.after)


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated:
    """What was measured, or given, of a device; ``None`` keeps what is written."""

    date: str
    directions: Pair | None = None
    """Of the joints' encoders."""
    torque_signs: Pair | None = None
    """By which each drive's direction is multiplied."""
    home: tuple[float, float] | None = None
    serial: str | None = None
    estop: bool = False

    def apply(self, document: Any) -> None:
        """Change a document of YAML in place."""
        document["date"] = self.date
        if self.home is not None:
            document["home"] = list(self.home)
        if self.serial is not None:
            document["serial"] = self.serial
        if self.estop:
            document["estop"] = "confirmed"
        for index in (0, 1):
            if self.directions is not None:
                _joint(document, index)["direction"] = self.directions[index]
            if self.torque_signs is not None and self.torque_signs[index] < 0:
                drive = _joint(document, index).setdefault("drive", {})
                drive["direction"] = -drive.get("direction", 1)


def calibrated(path: Path, base: Path | None, kind: type[DriverFacts], found: Calibrated) -> Edit:
    """The file at ``path`` with what was found; where there is none, ``base``'s, or a new one.

    Raises:
        InputError: it cannot be read, or cannot be a device file afterwards.
    """
    source = path if path.exists() else base
    text = "" if source is None else source.read_text("utf-8")
    if source is not None and load(source).driver != kind.driver:
        raise InputError(f"{source} is a device file for '{load(source).driver}': name another")
    new = {"cohaptic_device": 1, "driver": kind.driver, "preset": kind.preset}
    return Edit(
        path, text if source == path else "", _changed(text or _text(new), path, found.apply)
    )


def save(path: Path, values: Mapping[str, Any]) -> None:
    """Write a device file; it is parsed first, so a broken one is never left behind."""
    parse(values)
    Edit(path, "", _text(dict(values))).write()


def add_watchdog_proof(path: Path, proof: WatchdogProof) -> None:
    """Note a proof in a device file; everything else in it stays, comments included."""

    def note(document: Any) -> None:
        document["watchdog_proof"] = {k: v for k, v in asdict(proof).items() if v is not None}
        if proof.serial is not None:
            document.setdefault("serial", proof.serial)

    before = path.read_text("utf-8")
    Edit(path, before, _changed(before, path, note)).write()


def _joint(document: Any, index: int) -> Any:
    joints = document.setdefault("joints", [{}, {}])
    return joints[index]


def _changed(text: str, path: Path, change: Callable[[Any], None]) -> str:
    editor = _editor()
    if "\n  - " in text:  # lists stay as far in as they were written
        editor.indent(mapping=2, sequence=4, offset=2)
    document: Any = editor.load(text)
    change(document)
    after = _dumped(editor, document)
    try:
        parse(_editor().load(after))
    except InputError as error:
        raise InputError(f"{path} could not be used afterwards: {error}") from error
    return after


def _text(values: dict[str, Any]) -> str:
    return _dumped(_editor(), values)


def _dumped(editor: Any, document: Any) -> str:
    stream = StringIO()
    editor.dump(document, stream)
    return stream.getvalue()


def _editor() -> Any:
    from ruamel.yaml import YAML

    editor = YAML()
    editor.default_flow_style = False
    editor.preserve_quotes, editor.width = True, 4096
    return editor
