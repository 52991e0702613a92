"""The Modelica Association's Reference FMUs, compiled here from a checkout of their sources."""

from __future__ import annotations

import re
import subprocess
import zipfile
from pathlib import Path

from fmus.compiler import compiler_path

PLACES = {2: "linux64", 3: "x86_64-linux"}
STATE_SPACE_SLIP = re.compile(r"ASSERT_NVALUES\(1\);\s*(M\([mnr]\) = v;)")
"""Structural parameters: the index is counted up before it is checked against the count, so a
single value is refused whatever the importer does."""


def model_names(sources: Path, version: int) -> list[str]:
    """The models that have a description of that FMI version."""
    return sorted(path.parent.name for path in sources.glob(f"*/FMI{version}.xml"))


def build(sources: Path, model: str, version: int, folder: Path) -> Path:
    """Compile and pack one model; returns the FMU."""
    code = folder / f"{model}_{version}.c"
    code.write_text(STATE_SPACE_SLIP.sub(r"\1", (sources / model / "model.c").read_text()))
    library = folder / f"{model}_{version}.so"
    command = [str(compiler_path()), "cc", "-target", "x86_64-linux-gnu.2.17", "-O1", "-shared"]
    command += ["-fPIC", "-fvisibility=hidden", "-fno-sanitize=undefined"]
    command += [f"-DFMI_VERSION={version}", "-DDISABLE_PREFIX"]
    command += [f"-I{sources / 'include'}", f"-I{sources / model}", str(code)]
    command += [str(sources / "src" / f"fmi{version}Functions.c")]
    command += [str(sources / "src" / "cosimulation.c"), "-lm", "-o", str(library)]
    subprocess.run(command, check=True)
    archive = folder / f"{model}.fmi{version}.fmu"
    with zipfile.ZipFile(archive, "w") as packed:
        packed.write(sources / model / f"FMI{version}.xml", "modelDescription.xml")
        packed.write(library, f"binaries/{PLACES[version]}/{model}.so")
        if (sources / model / "y.txt").exists():
            packed.write(sources / model / "y.txt", "resources/y.txt")
    return archive
