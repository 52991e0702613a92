"""What a command says: on the terminal and, dated, in a file; with ``-v`` also what it read."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.shown import shown
from cosim.cli.support.values import OutputFile

Command = Callable[..., Any]


def journal_options(command: Command) -> Command:
    """``--log-file`` and ``-v``."""
    log = click.option(
        "--log-file",
        type=OutputFile(),
        help="Append everything that is said, dated, to this file.",
    )
    verbose = click.option(
        "-v", "--verbose", is_flag=True, help="Say what was read, built and recorded as well."
    )
    return log(verbose(command))


class Journal:
    """Says sentences; those of a file that cannot be written any more are only shown."""

    def __init__(self, file: Path | None = None, *, verbose: bool = False) -> None:
        """``file`` is appended to, line by line, also from child processes.

        Raises:
            InputError: it cannot be opened.
        """
        self._verbose = verbose
        self._file: int | None = None
        if file is not None:
            try:
                flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
                self._file = os.open(file, flags, 0o644)
            except OSError as error:
                raise InputError(f"{file}: cannot be written ({error.strerror}).") from error

    def say(self, sentence: str) -> None:
        """Beside the command's output: a warning, a question, how a run ended."""
        shown.say(sentence)
        self.keep(sentence)

    def detail(self, sentence: str) -> None:
        """What only ``-v`` and the file want to know."""
        if self._verbose:
            shown.say(sentence)
        self.keep(sentence)

    def result(self, text: str) -> None:
        """The command's output, on standard output."""
        click.echo(text)
        self.keep(text)

    def keep(self, text: str) -> None:
        """For the file alone: what somebody else shows, such as an error that ends the command."""
        if self._file is None:
            return
        date = datetime.now(UTC).isoformat(timespec="milliseconds")
        lines = "".join(f"{date} {line}\n" for line in text.splitlines() if line.strip())
        try:
            os.write(self._file, lines.encode(errors="replace"))
        except OSError as error:
            os.close(self._file)
            self._file = None
            shown.say(f"warning: the log file ends here: {error.strerror}.")


def details(manifest: Mapping[str, Any]) -> list[str]:
    """What a run read and built, from its manifest, a line each."""
    found = [f"scenario {manifest['scenario'].get('file') or manifest['scenario'].get('name')}"]
    for name, part in manifest.get("components", {}).items():
        fmu = f", FMI {part['fmi']}, sha256 {part['sha256'][:12]}" if "sha256" in part else ""
        found.append(f"component {name}: {part['kind']} {part['source']}{fmu}")
    found += [f"file {path}: sha256 {digest[:12]}" for path, digest in manifest["files"].items()]
    found += [f"note: {note}" for note in manifest.get("notes", [])]
    return found
