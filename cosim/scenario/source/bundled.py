"""The scenarios that come with cohaptic; overlays, presets and fragments lie beside them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cosim.base.document.yaml_reader import read_yaml
from cosim.scenario.source.find import bundled_folder, bundled_names, shown_name


@dataclass(frozen=True, slots=True)
class BundledScenario:
    """A scenario's name for ``cohaptic run``, and what its file says of it."""

    name: str
    title: str
    description: str
    file: Path


def bundled_scenarios() -> list[BundledScenario]:
    """All of them by name: the files that name the version of the scenario language."""
    return [found for name in bundled_names() if (found := _read(name)) is not None]


def _read(name: str) -> BundledScenario | None:
    file = bundled_folder() / f"{name}.yaml"
    root = read_yaml(file, shown_name(file)).value
    if not isinstance(root, dict) or "cohaptic" not in root:
        return None
    title, description = (
        " ".join(str(root[key].value).split()) if key in root else ""
        for key in ("title", "description")
    )
    return BundledScenario(name, title, description, file)
