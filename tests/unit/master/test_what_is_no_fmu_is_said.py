"""Archives and folders of strangers that cannot be read end in a sentence, never in a traceback."""

from __future__ import annotations

import os
import re
import shutil
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.master.fmu.reading import read_description
from cosim.master.run.simulation import assemble
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.master.master_support import scenario_of

Y = scalar(3, "y", 1, causality="output", start="3", initial="exact")
STRUCTURE = '<Output valueReference="1" dependencies=""/>'


@pytest.fixture
def fmu(tmp_path: Path) -> Path:
    return foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE)


def described(path: Path, change: Callable[[str], str]) -> Path:
    """The same FMU with another description."""
    new = path.with_name("changed.fmu")
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(new, "w") as archive:
        for entry in old.namelist():
            content = old.read(entry)
            if entry == "modelDescription.xml":
                content = change(content.decode()).encode()
            archive.writestr(entry, content)
    return new


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda _: '<fmiModelDescription fmiVersion="1.0" modelName="m"/>', "an FMU of FMI 1.0; "),
        (lambda text: text.replace('"3.0"', '"4.0"', 1), "is an FMU of FMI 4.0; export it again"),
        (lambda text: text.replace('fmiVersion="3.0"', ""), "does not say its fmiVersion"),
        (lambda text: text.replace('Identifier="', 'Identifier="/usr/lib/'), "which is a path"),
        (lambda text: text.replace('Identifier="', 'Identifier="../../x/'), "which is a path"),
        (lambda text: re.sub("<(ModelVariables).*</\\1>", "", text, flags=re.S), "no ModelVar"),
        (lambda _: "<SystemStructureDescription/>", "begins with <SystemStructureDescription>, so"),
        (lambda _: "", "cannot be read: Document is empty"),
        (lambda text: text[:200], r"cannot be read: .*line \d"),
        (lambda text: text.replace("UTF-8", "UTF-99"), "cannot be read: Unsupported encoding"),
    ],
)
def test_a_description_of_something_else_is_called_that(
    fmu: Path, change: Callable[[str], str], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        read_description(described(fmu, change))


@pytest.mark.parametrize(
    ("entry", "content", "said"),
    [
        ("resources/" + "x/" * 2000 + "y", "", "2002 folders deep .*; it is refused"),
        ("modelDescription.xml", "<a/>", "two different entries 'modelDescription.xml'"),
        ("modelDescription.xml/x", "", "could not be unpacked"),
    ],
)
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_an_entry_that_cannot_be_unpacked_is_named(
    fmu: Path, entry: str, content: str, said: str
) -> None:
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr(entry, content)
    with pytest.raises(InputError, match=said):
        read_description(fmu)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_the_same_entry_twice_is_no_harm(fmu: Path) -> None:
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("modelDescription.xml", archive.read("modelDescription.xml"))
    assert read_description(fmu).variables


def test_an_encrypted_archive_is_called_that(fmu: Path) -> None:
    content = bytearray(fmu.read_bytes())
    content[content.find(b"PK\x03\x04") + 6] |= 1
    content[content.find(b"PK\x01\x02") + 8] |= 1
    fmu.write_bytes(content)
    with pytest.raises(InputError, match=r"is encrypted \('modelDescription.xml'\)"):
        read_description(fmu)


@pytest.mark.skipif(sys.platform != "linux", reason="names that are no text")
def test_files_with_names_that_are_no_text_are_files(fmu: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    (folder / "resources").mkdir()
    shutil.copy(fmu, os.fsencode(folder / "resources") + b"/\xff\xfe")
    pipe, link = folder / "resources" / "pipe", folder / "resources" / "nowhere"
    os.mkfifo(pipe)
    link.symlink_to("/nowhere")
    with pytest.raises(InputError, match=r"resources/(pipe|nowhere): .*\(and 1 more\)$"):
        read_description(folder)
    pipe.unlink()
    link.unlink()
    assert read_description(folder).variables


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        ('<Dimension start="-1"/>', "line 6 .*: a: it has a dimension of -1"),
        ('<Dimension start="9"/><Dimension start="200000"/>', "9 × 200000 elements, more than"),
        ('<Dimension start="4000000000000000000"/>', "more than the 1000000 carried"),
    ],
)
def test_an_array_has_a_size_that_can_be_carried(tmp_path: Path, inside: str, said: str) -> None:
    values = Y + scalar(3, "a", 2, inside=inside, causality="local")
    with pytest.raises(InputError, match=said):
        read_description(foreign_fmu(tmp_path, 3, values, structure=STRUCTURE))


def test_a_size_that_a_scenario_gives_can_be_carried(tmp_path: Path) -> None:
    size = scalar(
        3, "n", 2, "UInt64", causality="structuralParameter", variability="fixed", start="2"
    )
    array = scalar(3, "a", 3, inside='<Dimension valueReference="2"/>', causality="local")
    fmu = foreign_fmu(tmp_path, 3, Y + size + array, structure=STRUCTURE)
    assert read_description(fmu, {"n": 7}).variables["a"].shape == (7,)
    with pytest.raises(InputError, match="a: it has 1000000000 elements, more than the 1000000"):
        read_description(fmu, {"n": 1_000_000_000})


TERMINAL = '<Terminal name="{0}"><TerminalMemberVariable variableName="{1}"/></Terminal>'


@pytest.mark.parametrize(
    ("terminals", "said"),
    [
        (TERMINAL.format("plug", "y"), None),
        (TERMINAL.format("plug", "nothing"), 'the terminal "plug" has a member "nothing" that is'),
        (TERMINAL.format("plug", "y") * 2, 'two terminals are called "plug"'),
        ("<Terminal", "its terminals are left out: terminalsAndIcons.xml cannot be read: "),
    ],
)
def test_what_is_wrong_with_terminals_is_noted(
    tmp_path: Path, terminals: str, said: str | None
) -> None:
    text = f"<fmiTerminalsAndIcons><Terminals>{terminals}</Terminals></fmiTerminalsAndIcons>"
    extra = {"terminalsAndIcons/terminalsAndIcons.xml": text}
    found = read_description(foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE, extra=extra)).breaks
    assert (found == ()) if said is None else (len(found) == 1 and found[0].startswith(said))


UNIT = '<UnitDefinitions><Unit name="m"><BaseUnit m="1" factor="1"/></Unit></UnitDefinitions>'


@pytest.mark.parametrize("wrong", ['m="1" factor="0"', 'm="1" factor="NaN"', 'm="1" factor="INF"'])
def test_a_unit_that_nothing_converts_to_is_refused(tmp_path: Path, wrong: str) -> None:
    fmu = foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE, before=UNIT)
    assert read_description(fmu).units["m"].factor == 1
    broken = described(fmu, lambda text: text.replace('m="1" factor="1"', wrong))
    with pytest.raises(InputError, match="nothing converts to its unit m: one of the powers"):
        read_description(broken)


def test_a_clock_that_ticks_after_every_run_is_refused(tmp_path: Path) -> None:
    clock = (
        '<Clock name="c" valueReference="2" causality="input" intervalVariability="constant" '
        'intervalDecimal="1e300"/>'
    )
    interface = {"hasEventMode": "true"}
    fmu = foreign_fmu(tmp_path, 3, Y + clock, structure=STRUCTURE, interface=interface)
    text = f"duration: 1\ncomponents:\n  it: {{fmu: {fmu}, rate: 10}}\n"
    with pytest.raises(InputError, match=r"clock c has an interval of 1e\+300 s, longer than any"):
        assemble(scenario_of(tmp_path, text))


@pytest.mark.parametrize("time", ["1e-999999999", "x", "1/0", "0x1", "1_0"])
@pytest.mark.parametrize("key", ["stepSize", "fixedInternalStepSize"])
def test_a_time_that_is_none_is_refused(tmp_path: Path, key: str, time: str) -> None:
    """The exact value of ``1e-999999999`` fills any memory."""
    own = {key: time} if key == "fixedInternalStepSize" else {}
    before = "" if own else f'<DefaultExperiment {key}="{time}"/>'
    fmu = foreign_fmu(tmp_path, 3, Y, structure=STRUCTURE, before=before, interface=own)
    with pytest.raises(InputError, match=f"the {key} of its .* is '{time}'"):
        read_description(fmu)


@pytest.mark.parametrize("time", ["1e999999999", "1e-999999999", "1e400", "1/0", "x"])
def test_a_clocks_interval_that_is_none_is_refused(tmp_path: Path, time: str) -> None:
    clock = (
        '<Clock name="c" valueReference="2" causality="input" intervalVariability="constant" '
        f'intervalDecimal="{time}"/>'
    )
    interface = {"hasEventMode": "true"}
    fmu = foreign_fmu(tmp_path, 3, Y + clock, structure=STRUCTURE, interface=interface)
    with pytest.raises(
        InputError, match=f"the clock c has the interval '{time}', which is no time"
    ):
        read_description(fmu).in_mode(True)
