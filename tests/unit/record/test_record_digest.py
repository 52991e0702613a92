"""Equal content gives an equal digest, and nothing else does."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
import pytest

from cosim.base.recording import Column, RecordGroup
from cosim.record import digest, layout, open_run
from tests.support.record.synthetic_run import RATE, Cells, write

FORCE = Column(name="vr_a.force", unit="N", is_float=True, description="what the finger feels")
STATE = Column(name="vr_a.state", unit=None, is_float=False)
GROUP = RecordGroup(name="control", period=2, columns=(FORCE, STATE))


@pytest.fixture
def cells() -> Cells:
    random = np.random.default_rng(3)
    return np.stack([random.normal(size=500).view(np.int64), np.arange(500)], axis=1)


def digest_of(
    folder: Path, cells: Cells, group: RecordGroup = GROUP, *, base_rate: Fraction = RATE
) -> str:
    write(folder / "run.h5", (group,), (cells,), base_rate=base_rate)
    with open_run(folder) as run:
        return digest(run)


def test_it_is_the_documented_hash(tmp_path: Path, cells: Cells) -> None:
    """Spelled out independently, as docs/record.md describes it."""
    import hashlib

    def text(value: str) -> bytes:
        return len(value.encode()).to_bytes(8, "little") + value.encode()

    def number(value: int) -> bytes:
        return value.to_bytes(8, "little", signed=True)

    expected = b"cohaptic run 1\n" + text("1024")
    expected += text("control") + number(2) + number(500) + number(2)
    expected += b"".join(number(2 * row) for row in range(500))
    expected += text("vr_a.force") + text("N") + text("float64") + cells[:, 0].tobytes()
    expected += text("vr_a.state") + text("") + text("int64") + cells[:, 1].tobytes()
    assert digest_of(tmp_path, cells) == hashlib.sha256(expected).hexdigest()


def test_file_layout_and_order_do_not_count(
    tmp_path: Path, cells: Cells, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = digest_of(tmp_path / "a", cells)
    turned = RecordGroup(name="control", period=2, columns=(STATE, replace(FORCE, description="")))
    assert digest_of(tmp_path / "b", cells[:, ::-1], turned) == original
    monkeypatch.setattr(layout, "SEGMENT_ROWS", 64)
    assert digest_of(tmp_path / "c", cells) == original
    files = [(tmp_path / name / "run.h5").read_bytes() for name in "ac"]
    assert files[0] != files[1]


def test_any_single_bit_counts(tmp_path: Path, cells: Cells) -> None:
    original = digest_of(tmp_path / "a", cells)
    for index, (row, column, bit) in enumerate([(0, 0, 0), (499, 1, 0), (250, 0, 63)]):
        other = cells.copy()
        other[row, column] ^= np.int64(-(2**63)) if bit == 63 else np.int64(1 << bit)
        assert digest_of(tmp_path / str(index), other) != original


def test_ticks_units_names_types_and_rates_count(tmp_path: Path, cells: Cells) -> None:
    others = [
        replace(GROUP, period=3),
        replace(GROUP, name="fast"),
        replace(GROUP, columns=(replace(FORCE, unit="kN"), STATE)),
        replace(GROUP, columns=(replace(FORCE, name="vr_b.force"), STATE)),
        replace(GROUP, columns=(replace(FORCE, is_float=False), STATE)),
    ]
    digests = {digest_of(tmp_path / str(i), cells, other) for i, other in enumerate(others)}
    digests.add(digest_of(tmp_path / "rate", cells, base_rate=Fraction(1000)))
    digests.add(digest_of(tmp_path / "shorter", cells[:-1]))
    digests.add(digest_of(tmp_path / "original", cells))
    assert len(digests) == len(others) + 3


def test_a_manifest_does_not_count(tmp_path: Path, cells: Cells) -> None:
    original = digest_of(tmp_path / "a", cells)
    (tmp_path / "a" / "manifest.json").write_text('{"started": "yesterday"}')
    with h5py.File(tmp_path / "a" / "run.h5", "r+") as file:
        file.attrs["note"] = "looked at"
    with open_run(tmp_path / "a") as run:
        assert digest(run) == original
