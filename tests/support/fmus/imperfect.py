"""One well-formed FMU of each version, and what may be changed in its description.

A break is the text that is replaced, what it becomes, and what the note (or the refusal) says of
it. The harmless ones leave no doubt about what a variable is, where it is and how it is set.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

from tests.support.fmus.foreign import foreign_fmu

_ROOT = {
    2: '<fmiModelDescription fmiVersion="2.0" modelName="foreign" guid="0">',
    3: '<fmiModelDescription fmiVersion="3.0" modelName="foreign" instantiationToken="0">',
}
TIME = '<Float64 name="time" valueReference="63" causality="independent" variability="continuous"/>'
_VARIABLES = {
    2: """<ScalarVariable name="u" valueReference="1" causality="input" variability="continuous">
<Real start="0" declaredType="Length"/></ScalarVariable>
<ScalarVariable name="y" valueReference="2" causality="output" variability="continuous"
 initial="calculated"><Real unit="m"/></ScalarVariable>
<ScalarVariable name="p" valueReference="3" causality="parameter" variability="fixed"
 initial="exact"><Real start="1"/></ScalarVariable>
<ScalarVariable name="n" valueReference="4" causality="local" variability="discrete"
 initial="calculated"><Integer/></ScalarVariable>
<ScalarVariable name="e" valueReference="5" causality="parameter" variability="fixed"
 initial="exact"><Enumeration start="1" declaredType="Colour"/></ScalarVariable>
""",
    3: f"""{TIME}
<Float64 name="u" valueReference="1" causality="input" start="0" declaredType="Length"/>
<Float64 name="y" valueReference="2" causality="output" initial="calculated" unit="m"/>
<Float64 name="p" valueReference="3" causality="parameter" variability="fixed" start="1"/>
<Int32 name="n" valueReference="4" causality="local" variability="discrete"
 initial="calculated"/>
<Enumeration name="e" valueReference="5" causality="parameter" variability="fixed" start="1"
 declaredType="Colour"/>
""",
}
_TYPES = {
    2: """<SimpleType name="Length"><Real quantity="Length" unit="m"/></SimpleType>
<SimpleType name="Colour"><Enumeration><Item name="red" value="1"/><Item name="blue" value="2"/>
</Enumeration></SimpleType>""",
    3: """<Float64Type name="Length" quantity="Length" unit="m"/>
<EnumerationType name="Colour"><Item name="red" value="1"/><Item name="blue" value="2"/>
</EnumerationType>""",
}
_STRUCTURE = {
    2: """<Outputs><Unknown index="2" dependencies="1" dependenciesKind="dependent"/></Outputs>
<InitialUnknowns><Unknown index="2" dependencies="1"/></InitialUnknowns>""",
    3: """<Output valueReference="2" dependencies="1" dependenciesKind="dependent"/>
<InitialUnknown valueReference="2" dependencies="1"/>""",
}


def description(version: int) -> str:
    """It keeps every rule."""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
{_ROOT[version]}
<CoSimulation modelIdentifier="foreign" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
<TypeDefinitions>
{_TYPES[version]}
</TypeDefinitions>
<LogCategories><Category name="logAll"/></LogCategories>
<DefaultExperiment startTime="0" stopTime="1"/>
<ModelVariables>
{_VARIABLES[version]}</ModelVariables>
<ModelStructure>
{_STRUCTURE[version]}
</ModelStructure>
</fmiModelDescription>
"""


@dataclass(frozen=True, slots=True)
class Break:
    """What is done to the description of a version, and what is said of it."""

    version: int
    old: str
    new: str
    said: str


def broken_fmu(folder: Path, kind: Break | None, version: int = 0) -> Path:
    """The FMU of ``kind``'s version, or a perfect one of ``version``."""
    version = version if kind is None else kind.version
    text = description(version)
    if kind is not None:
        assert text.count(kind.old) == 1, kind.old
        text = text.replace(kind.old, kind.new)
    made = foreign_fmu(folder, version, "")
    path = folder / "imperfect.fmu"
    with zipfile.ZipFile(made) as old, zipfile.ZipFile(path, "w") as new:
        for entry in old.namelist():
            given = text if entry == "modelDescription.xml" else old.read(entry)
            new.writestr(entry, given)
    return path
