"""What the site has beside the pages of docs/: reference pages, made from what they are about.

A hook of MkDocs (mkdocs.yml). Links that lead out of docs/ are text there, but for those to a
model's page, which the site has.
"""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from posixpath import normpath, relpath
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))  # MkDocs loads a hook as no part of a package
from notebooks import files as notebooks, page_of  # noqa: I001

ROOT = Path(__file__).parents[3]
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)]*)?\)")
SECTION = re.compile(r"^(?:Args|Returns|Raises|Attributes|Yields):$", re.MULTILINE)
MODEL_PAGE = re.compile(r"reference/models/(\w+)\.md")
DATE = re.compile(r"(?<=\| )(\d{4})-(\d\d)-(\d\d)(?= \|)")
MODEL = re.compile(r"fmus/(\w+)/README\.md")


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are made."""
    from mkdocs.structure.files import File

    made = {
        "reference/commands.md": commands(),
        "reference/python.md": python_api(),
        "reference/models.md": models(),
        **{f"reference/models/{name}.md": text for name, text in model_pages().items()},
        **{f"notebooks/{file.stem}.md": page_of(file) for file in notebooks()},
    }
    for place, text in made.items():
        files.append(File.generated(config, place, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Links out of docs/ as text; those to a model's page to the site's own; dates in one piece."""
    del config, files
    markdown = DATE.sub("\\1\u2011\\2\u2011\\3", markdown)
    here = page.file.src_uri.rpartition("/")[0]
    model_page = MODEL_PAGE.fullmatch(page.file.src_uri)
    written = f"fmus/{model_page[1]}" if model_page else f"docs/{here}"

    def led(link: re.Match[str]) -> str:
        image, text, target, anchor = link[1], link[2], link[3], link[4] or ""
        if "://" in target:
            return link[0]
        place = normpath(f"{written}/{target}")
        model = MODEL.fullmatch(place)
        if not place.startswith("docs/") and model is None:
            return text
        led_to = f"reference/models/{model[1]}.md" if model else place.removeprefix("docs/")
        inside = relpath(led_to, here or ".")
        return f"{image}[{text}]({inside}{anchor})"

    return LINK.sub(led, markdown)


def commands() -> str:
    """Every command with its help, as ``--help`` prints it."""
    import click

    from cosim.cli import cli

    parts = ["# Commands\n"]

    def walk(group: click.Group, path: str) -> None:
        for name in group.list_commands(click.Context(group)):
            command = group.get_command(click.Context(group), name)
            assert command is not None
            full = f"{path} {name}"
            context = click.Context(command, info_name=full, max_content_width=90)
            parts.append(f"## {full}\n\n```text\n{command.get_help(context)}\n```\n")
            if isinstance(command, click.Group):
                walk(command, full)

    walk(cli, "cohaptic")
    return "\n".join(parts)


def python_api() -> str:
    """Every public name with its signature and its docstring."""
    import cohaptic

    parts = ["# `import cohaptic`\n"]
    for name in cohaptic.__all__:
        found = getattr(cohaptic, name)
        parts.append(f"## {name}\n")
        if callable(found) and not inspect.isclass(found):
            parts.append(f"```python\n{name}{inspect.signature(found)}\n```\n")
        elif inspect.isclass(found):
            members = [
                f"- `{member}`: {(inspect.getdoc(value) or '').partition(chr(10))[0]}"
                for member, value in vars(found).items()
                if not member.startswith("_") and (callable(value) or isinstance(value, property))
            ]
            parts.append(_said_of(found))
            parts.append("\n".join(members) + "\n")
            continue
        parts.append(_said_of(found))
    return "\n".join(parts)


def _said_of(found: Any) -> str:
    """A docstring: its sentences, and as they stand there arguments, what is returned, errors."""
    text = inspect.getdoc(found) or ""
    begins = SECTION.search(text)
    if begins is None:
        return f"{text.strip()}\n"
    prose, sections = text[: begins.start()].strip(), text[begins.start() :].rstrip()
    return f"{prose}\n\n```text\n{sections}\n```\n"


def model_pages() -> dict[str, str]:
    """The page of each bundled FMU, which lies beside its sources."""
    return {
        file.parent.name: file.read_text(encoding="utf-8")
        for file in sorted(ROOT.glob("fmus/*/README.md"))
    }


def models() -> str:
    """The table of bundled FMUs."""
    rows = ["# Models", "", "| FMU | what it is |", "|---|---|"]
    for name, text in model_pages().items():
        lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
        rows.append(f"| [{name}](models/{name}.md) | {lines[0] if lines else ''} |")
    return "\n".join(rows) + "\n"
