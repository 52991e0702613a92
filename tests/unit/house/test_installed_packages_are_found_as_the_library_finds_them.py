"""Entry points and versions are those of ``importlib.metadata``, which is asked only where due."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from importlib.metadata import distributions, entry_points, version
from pathlib import Path

import pytest

from cosim.base.system.installed import registered, version_of


@pytest.mark.parametrize("group", ["cohaptic.devices", "console_scripts", "pytest11", "no.such"])
def test_the_entry_points_of_a_group_are_the_same(group: str) -> None:
    assert set(registered(group)) == set(entry_points(group=group))


def test_the_version_of_every_package_is_the_same() -> None:
    names = {each.metadata["Name"] for each in distributions()}
    assert {"cohaptic", "numpy", "h5py"} <= names
    assert {name: version_of(name) for name in names} == {name: version(name) for name in names}
    assert version_of("no-such-package") is None


@pytest.mark.parametrize("packed", [False, True], ids=["folder", "zip"])
def test_a_package_is_found_wherever_it_lies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, packed: bool
) -> None:
    files = {
        "METADATA": "Metadata-Version: 2.1\nName: extra\nVersion: 1.5\n",
        "entry_points.txt": "[a.group]\nword = extra:WORD\n",
    }
    place = tmp_path / "site"
    if packed:
        with zipfile.ZipFile(place, "w") as archive:
            for name, text in files.items():
                archive.writestr(f"extra-1.5.dist-info/{name}", text)
    else:
        folder = place / "extra-1.5.dist-info"
        folder.mkdir(parents=True)
        for name, text in files.items():
            (folder / name).write_text(text, "utf-8")
    monkeypatch.syspath_prepend(str(place))
    assert [(entry.name, entry.value) for entry in registered("a.group")] == [
        ("word", "extra:WORD")
    ]
    assert version_of("extra") == "1.5"


def test_a_group_that_nobody_registers_costs_no_import() -> None:
    code = (
        "import sys; from cosim.base.system.installed import registered; "
        "assert registered('no.such') == (); print('importlib.metadata' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
