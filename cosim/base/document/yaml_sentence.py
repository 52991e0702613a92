"""What is wrong with broken YAML, in the words of somebody who writes scenarios, and where.

A parser stops where it cannot go on, which is often far behind the mistake: an open quote is found
out at the end of the file. The sentences here point at the mistake.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from cosim.base.document.typography import comma_in_number, odd_characters

CLOSING = {"[": "]", "{": "}"}

_PATTERN = re.compile(r"\*[^\s,\]}]*")
_TOKEN = re.compile(r"""(?P<quoted>"(?:[^"\\]|\\.)*"|'(?:[^']|'')*')|\#[^\n]*|[][{}]""", re.DOTALL)
_ODD_INDENT = re.compile(r"^ *(?=[\u00a0\u2007\u202f\u3000])", re.MULTILINE)
_GLUED = re.compile(r"[\w.\"'-]+:(?=\S)")
_EQUALS = re.compile(r"[\w.]+\s*=")


@dataclass(frozen=True, slots=True)
class Mark:
    """A place in the text; all from 0."""

    index: int
    line: int
    column: int


def sentence(error: Any, text: str) -> tuple[str, Mark]:
    """The message for one of ruamel's marked errors, and the place that it points at."""
    problem, context = str(error.problem or ""), str(error.context or "")
    found, opened = _mark(error.problem_mark), _mark(error.context_mark or error.problem_mark)
    rest = text[found.index :]
    before = text[found.index - found.column : found.index]
    quote = _late_quote(text, found)
    if "an alias" in context or "undefined alias" in problem:
        return _alias(text, opened if "an alias" in context else found)
    if context in {"while parsing a flow mapping", "while parsing a flow sequence"}:
        return _in_brackets(text, opened, found, quote)
    if "quoted scalar" in context:
        return _in_quotes(text, opened, found, problem)
    if rest.startswith("\t") and not before.strip():
        return "a tab indents this line; YAML wants spaces.", found
    odd = _ODD_INDENT.search(text, 0, found.index + 1)
    if odd:
        return "a no-break space indents this line; YAML wants plain spaces.", _at(text, odd.end())
    if "cannot start any token" in problem:
        return f"text that begins with '{rest[:1]}' needs quotes.", found
    if "a block scalar" in context:
        return f"text that begins with '{text[opened.index]}' needs quotes.", opened
    if "mapping values are not allowed" in problem:
        return (
            "a ':' too many: either the indentation is off, or text with ': ' in it needs quotes."
        ), found
    if quote is not None:
        return "the quote that opens here closes only at the next one, where another opens.", quote
    if "could not find expected ':'" in problem:
        return _no_colon(text, opened)
    if "expected <block end>" in problem:
        return _block_end(found, rest, before)
    if "expected the node content" in problem:
        if not rest.strip("\0 \n"):
            return _in_brackets(text, _last_open(text), found, None)
        return f"a value is due before this '{rest[:1]}'.", found
    if "expected a single document" in context:
        return "a second '---' document; a scenario is one document.", found
    return f"broken YAML: {problem or context}{f' ({context})' if problem and context else ''}.", (
        found
    )


def without_value(key: str, before: str, lead: str) -> str:
    """The message for a member of ``{…}`` or ``[?…]`` without ':'.

    ``before`` is the value of the member in front, if only a comma is between them; ``lead`` is
    the character in front of the key.
    """
    if lead == "?":
        return f"text that begins with '?' needs quotes: '?{key}'."
    if re.fullmatch(r"[+-]?\d+(\.\d+)?", before) and re.match(r"\d", key):
        return comma_in_number(f"{before},{key}")
    if before:
        return f"inside {{…}} a text with a comma in it needs quotes: '{before},{key}'."
    name, colon, value = key.partition(":")
    if colon and value:
        return f"'{key}' has no value; write a space behind ':', as in '{name}: {value}'."
    name, equals, value = (part.strip() for part in key.partition("="))
    if equals and name and value:
        return f"'{key}' has no value; write ':' for '=', as in '{name}: {value}'."
    return f"'{key}' has no value; write '{key}: value'."


def _mark(mark: Any) -> Mark:
    return Mark(mark.index, mark.line, mark.column) if mark is not None else Mark(0, 0, 0)


def _at(text: str, index: int) -> Mark:
    start = text.rfind("\n", 0, index) + 1
    return Mark(index, text.count("\n", 0, index), index - start)


def _alias(text: str, mark: Mark) -> tuple[str, Mark]:
    match = _PATTERN.match(text, mark.index)
    pattern = match.group() if match else "*"
    if re.fullmatch(r"\*\w+", pattern):
        return f"there is no anchor '&{pattern[1:]}' before this '{pattern}'.", mark
    return f"a pattern that begins with '*' needs quotes: '{pattern}'.", mark


def _in_brackets(text: str, opened: Mark, found: Mark, quote: Mark | None) -> tuple[str, Mark]:
    bracket = text[opened.index]
    closing = CLOSING[bracket]
    end = _closed_at(text, opened.index)
    if quote is not None and quote.index > opened.index:
        return "the quote that opens here closes only at the next one, where another opens.", quote
    if end is None or end < found.index:
        return f"the '{bracket}' that opens here is never closed; '{closing}' is missing.", opened
    here = text[found.index : found.index + 1]
    if here in CLOSING or here in CLOSING.values():
        return f"a ',' or '{closing}' is due before this '{here}'; text with it needs quotes.", (
            found
        )
    if here == ":":
        return f"a second ':' in one member; is a ',' or '{closing}' missing before it?", found
    return f"a ',' or '{closing}' is missing before this.", found


def _closed_at(text: str, index: int) -> int | None:
    """Where the bracket at ``index`` is closed; quoted text and comments do not count."""
    opened = text[index]
    depth = 0
    for token in _TOKEN.finditer(text, index):
        if token.group() == opened:
            depth += 1
        elif token.group() == CLOSING[opened]:
            depth -= 1
            if depth == 0:
                return token.start()
    return None


def _last_open(text: str) -> Mark:
    """The innermost bracket that is still open where the text ends."""
    opened: list[int] = []
    for token in _TOKEN.finditer(text):
        if token.group() in CLOSING:
            opened.append(token.start())
        elif token.group() in CLOSING.values() and opened:
            opened.pop()
    return _at(text, opened[-1] if opened else 0)


def _in_quotes(text: str, opened: Mark, found: Mark, problem: str) -> tuple[str, Mark]:
    if "escape" in problem:
        return (
            "in double quotes '\\' begins an escape; write '\\\\', or use single quotes."
        ), found
    return f"the quote ({text[opened.index]}) that opens here is never closed.", opened


def _late_quote(text: str, found: Mark) -> Mark | None:
    """Where a quoted text opens that runs over several lines and ends right before ``found``."""
    for token in _TOKEN.finditer(text, 0, found.index + 1):
        quoted = token.group("quoted")
        if quoted and "\n" in quoted and not text[token.end() : found.index].strip():
            return _at(text, token.start())
    return None


def _no_colon(text: str, mark: Mark) -> tuple[str, Mark]:
    line = text[mark.index :].partition("\n")[0].rstrip()
    glued, equals = _GLUED.match(line), _EQUALS.match(line)
    if glued:
        name, value = glued.group(), line[glued.end() :]
        return f"write a space behind ':', as in '{name} {value}'.", mark
    if equals:
        name, _, value = (part.strip() for part in line.partition("="))
        return f"write ':' for '=', as in '{name}: {value}'.", mark
    if re.match(r"-\w|-\*", line):
        return f"write a space behind '-', as in '- {line[1:]}'.", mark
    return f"a key without ':'; it reads '{line[:40]}'.{odd_characters(line)}", mark


def _block_end(found: Mark, rest: str, before: str) -> tuple[str, Mark]:
    if rest[:1] in CLOSING.values():
        return f"this '{rest[:1]}' closes nothing.", found
    if before.rstrip().endswith(("'", '"')):
        return "text goes on behind its closing quote; put all of it in quotes.", found
    line = before + rest.partition("\n")[0]
    return f"the indentation fits nothing above it.{odd_characters(line)}", found
