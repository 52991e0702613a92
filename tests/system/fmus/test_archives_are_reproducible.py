"""The same sources give the same archive, byte for byte, and nothing is built twice."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import pytest

from fmus import builder
from fmus.archive import FLAVOURS, universal_binary, zip_bytes
from fmus.builder import build_fmus, source_digest
from fmus.compiler import PLATFORMS
from tests.support.fmus import fmu_support as support

NAME = "hand"


def archives(folder: Path) -> dict[str, bytes]:
    return {flavour: (folder / f"{NAME}.{flavour}.fmu").read_bytes() for flavour in FLAVOURS}


def test_building_again_elsewhere_gives_the_same_bytes(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        assert build_fmus(support.source(NAME), output=tmp_path / folder)
    assert archives(tmp_path / "one") == archives(tmp_path / "two")
    shipped = {flavour: support.path_of(NAME, flavour).read_bytes() for flavour in FLAVOURS}
    assert archives(tmp_path / "one") == shipped


def test_nothing_is_compiled_or_written_where_nothing_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "out"
    platforms = PLATFORMS[:1]
    assert build_fmus(support.source(NAME), platforms=platforms, output=output)

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("called the compiler")

    before = {path.name: path.stat().st_mtime_ns for path in output.iterdir()}
    with monkeypatch.context() as patch:
        patch.setattr(builder, "compile_library", refuse)
        assert not build_fmus(support.source(NAME), platforms=platforms, output=output)
        assert {path.name: path.stat().st_mtime_ns for path in output.iterdir()} == before
        with pytest.raises(AssertionError, match="called the compiler"):
            build_fmus(support.source(NAME), platforms=platforms, output=output, force=True)
    (output / f"{NAME}.fmi2.fmu").unlink()
    assert build_fmus(support.source(NAME), platforms=platforms, output=output)


def test_the_digest_sees_every_source(tmp_path: Path) -> None:
    import shutil

    from fmus.builder import Source

    source = support.source(NAME)
    folder = tmp_path / NAME
    shutil.copytree(source.folder, folder)
    copy = Source(source.model, folder)
    assert source_digest(copy) == source_digest(source)
    with (folder / "model.c").open("a") as file:
        file.write("\n")
    assert source_digest(copy) != source_digest(source)


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_dates_and_modes_are_fixed(flavour: str) -> None:
    with zipfile.ZipFile(support.path_of(NAME, flavour)) as archive:
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            assert entry.external_attr >> 16 == 0o644
        assert archive.namelist()[0] == "modelDescription.xml"


def test_a_zip_is_its_content() -> None:
    files = {"a": b"1", "b/c": b"2" * 1000}
    assert zip_bytes(files) == zip_bytes(dict(files))
    assert zip_bytes(files) != zip_bytes({"a": b"1", "b/c": b"3" * 1000})


def test_the_macos_binary_of_fmi2_holds_both_processors() -> None:
    with zipfile.ZipFile(support.path_of(NAME, "fmi3")) as archive:
        intel = archive.read(f"binaries/x86_64-darwin/{NAME}.dylib")
        arm = archive.read(f"binaries/aarch64-darwin/{NAME}.dylib")
    with zipfile.ZipFile(support.path_of(NAME, "fmi2")) as archive:
        fat = archive.read(f"binaries/darwin64/{NAME}.dylib")
    assert fat == universal_binary(intel, arm)
    magic, count = struct.unpack_from(">II", fat)
    assert (magic, count) == (0xCAFEBABE, 2)
    for i, image in enumerate((intel, arm)):
        cpu, _, offset, size, alignment = struct.unpack_from(">5I", fat, 8 + 20 * i)
        assert fat[offset : offset + size] == image
        assert offset % (1 << alignment) == 0
        assert struct.unpack_from("<I", image, 4)[0] == cpu  # the processor in Mach-O's own head
