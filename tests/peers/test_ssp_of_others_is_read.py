"""Systems of other makers are read or refused in a sentence; those that run, run; others read ours.

``uv run --group peers pytest -m peers tests/peers/test_ssp_of_others_is_read.py``
"""

from __future__ import annotations

import zipfile
from fractions import Fraction
from pathlib import Path

import pytest

from cosim.analysis import load_tuned
from cosim.base.errors import InputError
from cosim.cli.ssp.system import scenario_of_system
from cosim.master.run.simulation import assemble
from cosim.reading import FORMS
from cosim.ssp.exporting import to_ssp
from cosim.ssp.package import read_system
from tests.support.peers.corpus import checkout

pytestmark = pytest.mark.peers
RESOURCES = "testsuite/tests/resources"
LEAST_READ = 20


def test_every_structure_is_read_or_refused_in_a_sentence() -> None:
    files = [
        *(checkout("OMSimulator") / RESOURCES).rglob("*.ssd"),
        *(checkout("libcosim") / "tests" / "data").rglob("*.ssd"),
        *(checkout("libcosim") / "tests" / "data").rglob("*.ssp"),
        *(checkout("libcosim") / "tests" / "data").rglob("OspSystemStructure*.xml"),
        *checkout("demo-cases").rglob("OspSystemStructure.xml"),
    ]
    read, refused = [], {}
    for file in sorted(files):
        try:
            document, _ = read_system(file, Fraction(1))
        except InputError as error:
            refused[str(file)] = str(error)
        else:
            assert document["components"].keys() >= {
                each[end].partition(".")[0]
                for each in document["connections"]
                for end in ("from", "to")
            }
            read.append(file)
    assert len(read) >= LEAST_READ, refused


@pytest.mark.parametrize(
    "name",
    [
        "ssp/demo/SystemStructure.ssd",
        "ssp/demo/demo.ssp",
        "fmi2/quarter_truck/OspSystemStructure.xml",
    ],
)
def test_systems_of_libcosim_run(name: str) -> None:
    file = checkout("libcosim") / "tests" / "data" / name
    scenario = scenario_of_system(str(file), stop_time="0.01", sets=(), say=lambda _: None)
    with assemble(scenario) as simulation:
        assert simulation.run().ticks == scenario.ticks


def test_pyssp_standard_reads_ours(tmp_path: Path) -> None:
    from pyssp_standard.ssd import SSD

    scenario = load_tuned("two_users_box", forms=FORMS)
    with assemble(scenario) as simulation:
        (tmp_path / "box.ssp").write_bytes(to_ssp(simulation.assembly))
    with zipfile.ZipFile(tmp_path / "box.ssp") as archive:
        archive.extract("SystemStructure.ssd", tmp_path)
    with SSD(tmp_path / "SystemStructure.ssd", "r") as read:
        assert {element.name for element in read.system.elements} == set(scenario.components)
        assert len(read.connections()) > 50
