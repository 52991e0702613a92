"""Tabs between the words of a line, which YAML allows and ruamel's scanner does not."""

from __future__ import annotations

from functools import cache
from typing import Any


@cache
def tab_scanner() -> type[Any]:
    """A scanner to which a tab is white space everywhere but in the indentation of a line."""
    from ruamel.yaml.scanner import Scanner

    scanner: Any = Scanner

    class TabScanner(scanner):
        """Reads what YAML 1.2 calls separate-in-line: spaces and tabs."""

        def scan_to_next_token(self) -> None:
            """Skip white space and comments up to the next token."""
            while True:
                scanner.scan_to_next_token(self)
                length = _white(self.reader)
                if not length or _indents(self.reader, length):
                    return
                self.reader.forward(length)

        def scan_plain_spaces(self, indent: Any, start_mark: Any) -> Any:
            """The white space behind a word of a plain text, which may go on after it."""
            length = _white(self.reader)
            between = self.reader.prefix(length)
            if "\t" not in between:
                return scanner.scan_plain_spaces(self, indent, start_mark)
            self.reader.forward(length)
            if self.reader.peek() in "\r\n\x85\u2028\u2029":
                return scanner.scan_plain_spaces(self, indent, start_mark)
            return [between]

    return TabScanner


def _white(reader: Any) -> int:
    length = 0
    while reader.peek(length) in (" ", "\t"):
        length += 1
    return length


def _indents(reader: Any, length: int) -> bool:
    """Whether this white space begins a line that has something in it."""
    line = str(reader.buffer[reader.pointer - reader.column : reader.pointer])
    return not line.strip() and reader.peek(length) not in ("\r", "\n", "#", "\0")
