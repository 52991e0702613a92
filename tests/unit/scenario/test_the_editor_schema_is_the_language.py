"""The JSON schema that editors read is the one that the document's types give."""

from __future__ import annotations

import json
from typing import Any

from cosim.reading import FORMS
from cosim.scenario.form.document import Document, json_schema
from cosim.scenario.source.find import bundled_folder


def test_the_bundled_schema_is_up_to_date() -> None:
    file = bundled_folder() / "scenario.schema.json"
    assert json.loads(file.read_text("utf-8")) == json_schema(FORMS), (
        f"run: cohaptic check --schema > {file}"
    )


def test_every_key_of_the_language_is_in_it_and_described() -> None:
    schema = json_schema(FORMS)
    assert set(Document.model_fields) | {"include"} == set(schema["properties"])
    for name in ("ComponentForm", "ChannelForm"):
        for key, entry in schema["$defs"][name]["properties"].items():
            assert "description" in entry or key == "description", f"{name}.{key}"


def test_references_in_it_lead_somewhere() -> None:
    schema = json_schema(FORMS)

    def references(node: Any) -> list[str]:
        if isinstance(node, dict):
            own = [node["$ref"]] if isinstance(node.get("$ref"), str) else []
            return own + [r for value in node.values() for r in references(value)]
        return [r for value in node for r in references(value)] if isinstance(node, list) else []

    found = {reference.removeprefix("#/$defs/") for reference in references(schema)}
    assert found
    assert found <= set(schema["$defs"])
