"""``bench/ratios.py`` names what got slower than in the release before, and ends with status 1."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from types import ModuleType

import pytest

FILE = Path(__file__).parents[3] / "bench" / "ratios.py"


@pytest.fixture
def ratios(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    found = importlib.util.spec_from_file_location("ratios", FILE)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    monkeypatch.setattr(module, "FOLDER", tmp_path)
    return module


def test_what_is_slower_is_named_and_what_is_missing(
    ratios: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    old = {"loop": 1.0, "record": 2.0, "gone": 1.0}
    assert ratios.report(old, {"loop": 1.14, "record": 2.4, "new": 9.0}, 0.15) == 1
    said = capsys.readouterr().err.splitlines()
    assert said == ["gone: 1.00 before, none now", "record: 2.00 before, 2.40 now"]
    assert ratios.report({"loop": 1.0}, {"loop": 1.14, "new": 9.0}, 0.15) == 0


def test_the_latest_release_is_the_one_of_the_greatest_number(ratios: ModuleType) -> None:
    for version in ("0.9.0", "0.10.0", "0.2.0"):
        (ratios.FOLDER / f"{version}.json").write_text(json.dumps({"loop": 1.0}))
    assert ratios.versions()[-1] == "0.10.0"
    assert ratios.kept("0.9.0") == {"loop": 1.0}
    with pytest.raises(SystemExit, match=r"there are no ratios of 0\.3\.0"):
        ratios.kept("0.3.0")


def test_the_ratios_that_are_kept_are_those_that_are_measured(ratios: ModuleType) -> None:
    for path in FILE.with_name("ratios").glob("*.json"):
        kept = json.loads(path.read_text(encoding="utf-8"))
        assert set(kept) <= {*ratios.RATIOS, *ratios.MEMORY}
        assert all(ratio > 0 for ratio in kept.values())
    assert list(FILE.with_name("ratios").glob("*.json"))


def test_the_memory_of_a_program_is_its_own(ratios: ModuleType) -> None:
    held = [bytearray(b"x") * (200 << 20)]  # what a child must not be taken to have
    bare, more = (ratios._memory(f"held = bytearray(b'x') * ({size} << 20)") for size in (1, 60))
    assert len(held[0]) > 1024 * more > 1024 * bare + (50 << 20)
