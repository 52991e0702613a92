"""Every description follows the schema of its standard, and the rules that a schema cannot say.

The schemas are those of the standards, as FMPy brings them.
"""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import pytest
from lxml import etree

from tests.support.fmus import fmu_support as support

SCHEMAS = Path(fmpy.__file__).parent / "schema"


@cache
def schema(version: str) -> etree.XMLSchema:
    return etree.XMLSchema(file=str(SCHEMAS / version / f"{version}ModelDescription.xsd"))


def root_of(name: str, flavour: str) -> Any:
    with zipfile.ZipFile(support.path_of(name, flavour)) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))


@pytest.mark.parametrize(("name", "flavour"), support.EVERY)
def test_the_schema_finds_nothing(name: str, flavour: str) -> None:
    schema(flavour.partition("-")[0]).assertValid(root_of(name, flavour))


@pytest.mark.parametrize(("name", "flavour"), support.EVERY)
def test_a_tool_annotates_a_place_once_and_in_fmi_2_without_text(name: str, flavour: str) -> None:
    """FMI 2.0's Tool holds one element and nothing else, FMI 3.0's Annotation text or elements."""
    tag, key = ("Tool", "name") if flavour == "fmi2" else ("Annotation", "type")
    for place in root_of(name, flavour).iter("Annotations", "VendorAnnotations"):
        tools = list(place)
        assert {tool.tag for tool in tools} == {tag}
        names = [tool.get(key) for tool in tools]
        assert len(set(names)) == len(names)
        assert all(each.startswith("org.cohaptic.") for each in names)
        for tool in tools:
            text = "".join([tool.text or "", *(child.tail or "" for child in tool)]).strip()
            assert bool(text) != bool(len(tool))
            assert flavour != "fmi2" or len(tool) == 1


def enumerations(root: Any) -> dict[str, set[str]]:
    """The values of each type."""
    kinds = [*root.iter("EnumerationType")]
    kinds += [
        simple for simple in root.iter("SimpleType") if simple.find("Enumeration") is not None
    ]
    return {kind.get("name"): {item.get("value") for item in kind.iter("Item")} for kind in kinds}


@pytest.mark.parametrize(("name", "flavour"), support.EVERY)
def test_an_enumeration_is_a_scalar_of_its_type_with_nothing_in_it(name: str, flavour: str) -> None:
    """The schema of FMI 3.0.0, which checkers still have, forbids more."""
    root = root_of(name, flavour)
    known = enumerations(root)
    for variable in root.find("ModelVariables").iter("Enumeration"):
        values = known[variable.get("declaredType")]
        assert {variable.get("start")} <= values | {None}
        assert flavour == "fmi2" or not list(variable)


def test_an_array_of_enumerations_is_among_them() -> None:
    root = root_of("operator", "fmi3-arrays").find("ModelVariables")
    names = {variable.get("name") for variable in root.iter("Enumeration")}
    assert {"force_mode[1]", "force_mode[2]"} <= names
