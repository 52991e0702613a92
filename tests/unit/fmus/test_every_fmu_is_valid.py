"""Every archive of every model is what its standard says it is."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.compiler import PLATFORMS
from fmus.description3 import TERMINALS_FILE
from tests.support.fmus import fmu_support as support

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"


@pytest.mark.parametrize(("name", "flavour"), support.EVERY)
def test_fmpy_finds_no_problem(name: str, flavour: str) -> None:
    path = str(support.path_of(name, flavour))
    if flavour == "fmi3":
        assert validate_fmu(path) == []
    else:  # all but the grammar of names, which is slow: they are those of the archive above
        read_model_description(path, validate=True, validate_model_structure=True)


@pytest.mark.parametrize("name", support.MODELS)
def test_terminals_follow_their_schema_and_name_variables(name: str) -> None:
    model = support.source(name).model
    for flavour in ("fmi2", "fmi3", "fmi3-arrays"):
        _, description = support.unpacked(name, flavour)
        known = {variable.name for variable in description.modelVariables}
        with zipfile.ZipFile(support.path_of(name, flavour)) as archive:
            if not model.terminals:
                assert TERMINALS_FILE not in archive.namelist()
                continue
            root = etree.fromstring(archive.read(TERMINALS_FILE))
        etree.XMLSchema(file=str(SCHEMA)).assertValid(root)
        members = [member.get("variableName") for member in root.iter("TerminalMemberVariable")]
        assert members
        assert set(members) <= known


@pytest.mark.parametrize("name", support.MODELS)
def test_there_is_a_binary_for_every_platform(name: str) -> None:
    with zipfile.ZipFile(support.path_of(name, "fmi3")) as archive:
        fmi3 = {entry.split("/")[1] for entry in archive.namelist() if "binaries/" in entry}
    with zipfile.ZipFile(support.path_of(name, "fmi2")) as archive:
        fmi2 = {entry.split("/")[1] for entry in archive.namelist() if "binaries/" in entry}
    assert fmi3 == {platform.name for platform in PLATFORMS}
    assert fmi2 == {"linux64", "win64", "darwin64"}


@pytest.mark.parametrize("name", support.MODELS)
def test_the_archive_carries_the_licences(name: str) -> None:
    with zipfile.ZipFile(support.path_of(name)) as archive:
        text = b"".join(archive.read(n) for n in archive.namelist() if "documentation/lic" in n)
    for owner in (b"MODELISAR consortium", b"Rich Felker"):
        assert owner in text


@pytest.mark.parametrize("name", support.MODELS)
def test_descriptions_of_all_flavours_tell_the_same(name: str) -> None:
    def facts(flavour: str) -> dict[str, tuple[object, ...]]:
        _, description = support.unpacked(name, flavour)
        return {
            v.name: (v.valueReference, v.causality, v.variability, v.unit, v.start, v.description)
            for v in description.modelVariables
            if v.name != "time"
        }

    assert facts("fmi2") == facts("fmi3")
    scalar = facts("fmi3")
    for variable, fact in facts("fmi3-arrays").items():
        first = scalar.get(variable) or scalar[f"{variable}[1]"]
        assert fact[:4] == first[:4]
