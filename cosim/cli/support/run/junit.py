"""Verdicts of runs as JUnit's XML, which every CI service shows.

A suite a scenario; in it a case for the run itself and one for each expectation. The elements are
those of the schema that Jenkins' xunit plugin publishes (junit-10.xsd).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast
from xml.etree import ElementTree as ET

from cosim.base.document.xml_text import xml_text
from cosim.base.errors import CohapticError


@dataclass(frozen=True, slots=True)
class RunEnd:
    """How one scenario ended: its summary's content, or the error for which there is none."""

    name: str
    content: Mapping[str, Any] | None
    error: CohapticError | None = None

    @property
    def status(self) -> int:
        """The exit status that it stands for."""
        if self.error is not None:
            return self.error.exit_status
        return 1 if self.content is None else int(self.content["status"])

    @property
    def message(self) -> str:
        """Why it did not run to its end; empty where it did."""
        if self.error is not None:
            return str(self.error)
        return "" if self.content is None else str(self.content["message"])


def junit(ends: Sequence[RunEnd]) -> bytes:
    """The XML of several runs, UTF-8 with its declaration."""
    root = ET.Element("testsuites", name="cohaptic")
    counts = dict.fromkeys(("tests", "failures", "errors"), 0)
    for end in ends:
        suite = _suite(end)
        root.append(suite)
        for key in counts:
            counts[key] += int(suite.attrib[key])
    for key, count in counts.items():
        root.set(key, str(count))
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def _suite(end: RunEnd) -> ET.Element:
    content = end.content or {}
    cases = [_run_case(end)]
    failed = errors = 0
    if end.status and end.message:
        ET.SubElement(cases[0], "error", message=xml_text(end.message))
        errors = 1
    elif content.get("runaways"):
        ET.SubElement(cases[0], "failure", message=xml_text("; ".join(content["runaways"])))
        failed = 1
    for verdict in content.get("expectations", []):
        case = ET.Element("testcase", classname=xml_text(end.name), name=xml_text(_claim(verdict)))
        if not verdict["passed"]:
            ET.SubElement(case, "failure", message=xml_text(f"measured {_measured(verdict)}"))
            failed += 1
        cases.append(case)
    suite = ET.Element("testsuite", name=xml_text(end.name), tests=str(len(cases)))
    suite.set("failures", str(failed))
    suite.set("errors", str(errors))
    suite.set("time", f"{content.get('wall_time', 0.0):.3f}")
    suite.extend(cases)
    return suite


def _run_case(end: RunEnd) -> ET.Element:
    case = ET.Element("testcase", classname=xml_text(end.name), name="runs to its end")
    if end.content is not None:
        case.set("time", f"{end.content.get('wall_time', 0.0):.3f}")
        ET.SubElement(case, "system-out").text = xml_text(str(end.content["run"]))
    return case


def _claim(verdict: Mapping[str, Any]) -> str:
    label = f" ({verdict['label']})" if verdict["label"] else ""
    limit = _shown(verdict["threshold"], verdict["unit"])
    return f"{verdict['target']}{label} {verdict['predicate']} {limit}"


def _measured(verdict: Mapping[str, Any]) -> str:
    value = verdict["measured"]
    found = None if value is None else _shown(value, verdict["unit"])
    return ", but ".join(part for part in (found, verdict["lacking"]) if part)


def _shown(value: Any, unit: str) -> str:
    numbers = cast("list[float]", value if isinstance(value, list) else [value])
    text = " to ".join(f"{number:g}" for number in numbers)
    return f"{text} {unit}".rstrip()
