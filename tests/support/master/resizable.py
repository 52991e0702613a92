"""An FMU with a structural parameter: none of the bundled ones has one."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

import fmus


def with_resizable_array(folder: Path) -> Path:
    """The pantograph with an ``initial_tip_position`` of ``n`` elements; it is never run."""
    path = folder / "resizable.fmu"
    with zipfile.ZipFile(fmus.find("pantograph", "fmi3-arrays")) as old:
        contents = {name: old.read(name) for name in old.namelist()}
    text = contents["modelDescription.xml"].decode()
    variable = re.search(r'<Float64 name="initial_tip_position".*?</Float64>', text, re.DOTALL)
    assert variable is not None
    changed = variable[0].replace('<Dimension start="2" />', '<Dimension valueReference="9999"/>')
    assert changed != variable[0]
    size = '<UInt64 name="n" valueReference="9999" causality="structuralParameter" start="2"/>'
    contents["modelDescription.xml"] = text.replace(variable[0], size + changed).encode()
    with zipfile.ZipFile(path, "w") as new:
        for name, content in contents.items():
            new.writestr(name, content)
    return path
