"""What a variable is called says nothing to the link: what it means does."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

import pytest

import fmus
from cosim.base.errors import InputError
from cosim.base.meaning import OF_OWN_DEVICE, Meaning, Slot
from cosim.link.stream.bundle import FieldRole
from cosim.master.assembly.assemble import Assembly, put_together
from cosim.master.fmu.reading import read_description
from cosim.scenario import load
from cosim.station.contract import contract_of
from cosim.station.half import Half
from cosim.station.split import split

PARTS = '''
from cosim.base.component import Causality, Component, Variable, VariableType
from cosim.base.meaning import Meaning, Slot


class Part(Component):
    MEANS = {}
    NAMES = ("status", "source_age", "source_tick", "motor_status")

    @property
    def variables(self):
        sent = [
            Variable(
                name=name,
                type=VariableType.INT64,
                causality=Causality.OUTPUT,
                variability="discrete",
                meaning=self.MEANS.get(name),
            )
            for name in self.NAMES
        ]
        taken = [
            Variable(name=f"taken_{name}", type=VariableType.INT64, causality=Causality.INPUT,
                     variability="discrete", meaning=self.MEANS.get("taken"),
                     belongs_to=Slot(peer=2))
            for name in self.NAMES
        ]
        known = [
            Variable(name=f"how_much[{peer}]" if self.MEANS else f"peer_weight[{peer}]",
                     causality=Causality.INPUT, meaning=self.MEANS.get("weight"),
                     belongs_to=Slot(peer=peer))
            for peer in (1, 2)
        ]
        return [*sent, *taken, *known]

    def initialise(self, setup, inputs, outputs):
        pass


class Foreign(Part):
    """Its names are those of a workstation by accident."""


class Ours(Part):
    """Its names say nothing, its meanings everything."""
    NAMES = ("a", "b", "c", "d")
    MEANS = {
        "a": Meaning.SOURCE_STATUS, "b": Meaning.SOURCE_AGE, "c": Meaning.SOURCE_TICK,
        "taken": Meaning.PEER_STATE, "weight": Meaning.PEER_WEIGHT,
    }
'''

TEXT = """cohaptic: 1
duration: 1
rates: {{control: 1024, network: 128}}
components:
  one: {{python: "parts:{kind}", station: a, rate: control}}
  two: {{python: "parts:{kind}", station: b, rate: control}}
channels: {{lan: {{between: [a, b], rate: network, each_way_delay: 1}}}}
connections: [{connections}]
"""


def _half(folder: Path, kind: str, names: tuple[str, ...]) -> Half:
    (folder / "parts.py").write_text(PARTS, "utf-8")
    connections = ", ".join(
        f"{here}.{name} -> {there}.taken_{name} via lan"
        for here, there in (("one", "two"), ("two", "one"))
        for name in names
    )
    file = folder / "s.yaml"
    file.write_text(TEXT.format(kind=kind, connections=connections), "utf-8")
    return split(put_together(load(file)), "b")


def test_a_foreign_output_called_status_does_not_switch_a_peer_off(tmp_path: Path) -> None:
    half = _half(tmp_path, "Foreign", ("status", "source_age", "source_tick", "motor_status"))
    (bundle,) = half.peers[0].receives
    assert {field.role for field in bundle.fields} == {FieldRole.VALUE}
    assert not [c for c in half.scenario.connections if "peer_weight" in str(c.target)]


def test_what_means_it_is_taken_so_whatever_it_is_called(tmp_path: Path) -> None:
    half = _half(tmp_path, "Ours", ("a", "b", "c", "d"))
    (bundle,) = half.peers[0].receives
    roles = {field.name: field.role for field in bundle.fields}
    assert roles == {
        "one.a": FieldRole.STATUS,
        "one.b": FieldRole.SOURCE_AGE,
        "one.c": FieldRole.SOURCE_TICK,
        "one.d": FieldRole.VALUE,
    }
    weights = [str(c) for c in half.scenario.connections if c.source.path.endswith(".weight")]
    assert weights == ["link_a.lan.weight -> two.how_much[2]"]


@pytest.fixture(scope="module", name="box")
def _box() -> Assembly:
    return put_together(load("two_users_box"))


def test_a_devices_status_is_no_peers_status(box: Assembly) -> None:
    """A pantograph's output is called 'status' as well; it would have stopped the peer."""
    variables = box.participants["finger_a1"].interface.variables
    assert variables["status"].meaning is None
    sent = box.participants["vr_a"].interface.variables["shared.status"]
    assert sent.meaning is Meaning.SOURCE_STATUS


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_every_archive_carries_the_same_meanings(flavour: str) -> None:
    interface = read_description(fmus.find("distributed_workstation", flavour)).interface(
        "vr", feedthrough=True
    )
    found = {
        name: (variable.meaning_of(element.index), variable.slot_of(element.index))
        for name, element in interface.elements.items()
        for variable in [interface.variables[element.variable]]
    }
    assert found["peer_weight[2]"] == (Meaning.PEER_WEIGHT, Slot(peer=2))
    assert found["peer_3.box_x"] == (Meaning.PEER_STATE, Slot(peer=3))
    assert found["finger_2.position[2]"] == (Meaning.FINGER_Y, Slot(finger=2))
    assert found["finger_1.normal_force"] == (Meaning.NORMAL_FORCE, Slot(finger=1))
    contact = found["peer_contact_2.finger_1_contact_state"]
    assert contact == (Meaning.CONTACT_STATE, Slot(peer=2, finger=1))
    assert found["box_pose.theta"] == (Meaning.BOX_ANGLE, Slot())
    assert found["shared.box_x"] == (None, Slot())
    variables = interface.variables
    assert variables["network_ticks"].meaning is Meaning.NETWORK_TICKS
    assert variables["finger_1.base_x"].meaning is Meaning.BASE_X


def test_the_contract_leaves_out_what_means_an_own_device(box: Assembly) -> None:
    half = split(box, "station_a")
    parameters = contract_of(box, half, half.peers[0])["components"]["vr_a"]["parameters"]
    declared = box.participants["vr_a"].interface.variables
    assert parameters
    assert not [n for n in parameters if declared[n].meaning in OF_OWN_DEVICE]
    assert "network_ticks" in parameters


def _changed(folder: Path, old: str, new: str) -> Path:
    """Our workstation with something else in its annotations."""
    archive = io.BytesIO(fmus.find("distributed_workstation", "fmi3").read_bytes())
    target = folder / "foreign.fmu"
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(target, "w") as copy:
        for entry in source.infolist():
            data = source.read(entry)
            if entry.filename == "modelDescription.xml":
                data = re.sub(old, new, data.decode(), flags=re.DOTALL).encode()
            copy.writestr(entry.filename, data)
    return target


def test_an_fmu_without_annotations_means_nothing(tmp_path: Path) -> None:
    path = _changed(tmp_path, r"<Annotations>.*?</Annotations>", "")
    variables = read_description(path).variables
    assert {variable.meaning for variable in variables.values()} == {None}


def test_a_meaning_as_text_is_read_as_before(tmp_path: Path) -> None:
    """FMUs that 0.1.0 built have it so."""
    path = _changed(tmp_path, r'<Meaning name="(\w+)"([^>]*)/>', r"<Meaning\2>\1</Meaning>")
    now = read_description(fmus.find("distributed_workstation", "fmi3")).variables
    assert {name: (v.meaning, v.belongs_to) for name, v in now.items()} == {
        name: (v.meaning, v.belongs_to) for name, v in read_description(path).variables.items()
    }


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"peer_weight"', '"peer_wait"', "means 'peer_wait', which is unknown. Did you mean peer_"),
        ('peer="1"', 'peer="first"', "has peer='first' in its meaning; it is a number from 1 on"),
        (r'<Meaning name="peer_weight"[^>]*/>', "", "has an annotation org.cohaptic.meaning wi"),
        (
            r'<Meaning (name="peer_weight"[^>]*)/>',
            r"<Meaning \1>peer_age</Meaning>",
            "means 'peer_weight' by name and 'peer_age' by text; write one of them",
        ),
        (
            r'variable="finger_1.contact_state"',
            'variable="finger_1.contact"',
            "of the model is for the variable 'finger_1.contact', which is none.",
        ),
        (
            r'variable="finger_1.contact_state"',
            'variable="finger_1.normal_force"',
            "variable 'finger_1.normal_force' has its meaning in two places",
        ),
    ],
)
def test_a_wrong_annotation_is_a_sentence(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    with pytest.raises(InputError) as caught:
        read_description(_changed(tmp_path, old, new))
    assert sentence in str(caught.value)
    assert "foreign.fmu: " in str(caught.value)


@pytest.mark.parametrize("meaning", ['"peer_weight"', "(Meaning.PEER_WEIGHT,) * 2"])
def test_a_python_components_meaning_is_a_meaning(tmp_path: Path, meaning: str) -> None:
    source = PARTS.replace('"weight": Meaning.PEER_WEIGHT', f'"weight": {meaning}')
    module = f"wrong_{len(meaning)}"  # a module of one name is loaded once
    (tmp_path / f"{module}.py").write_text(source, "utf-8")
    text = TEXT.format(kind="Ours", connections="").replace("parts:", f"{module}:")
    (tmp_path / "s.yaml").write_text(text, "utf-8")
    with pytest.raises(InputError, match=r"the meaning of 'how_much\[1\]' is .*; it has to be a"):
        put_together(load(tmp_path / "s.yaml"))
