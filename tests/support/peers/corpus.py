"""FMUs of other makers: fetched when the tests run, never part of this repository.

``COHAPTIC_PEERS`` names a folder with checkouts (``OMSimulator``, ``libcosim``, ``demo-cases``,
``Reference-FMUs``); what is not there is cloned into it.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
import zipfile
from pathlib import Path

from fmus.cache import cache_directory
from tests.support.peers.reference_fmus import build, model_names

SOURCES = {
    "OMSimulator": "https://github.com/OpenModelica/OMSimulator",
    "libcosim": "https://github.com/open-simulation-platform/libcosim",
    "demo-cases": "https://github.com/open-simulation-platform/demo-cases",
    "Reference-FMUs": "https://github.com/modelica/Reference-FMUs",
}
FOLDER = Path(os.environ.get("COHAPTIC_PEERS", cache_directory() / "peers"))
PYTHON_FMU = """from pythonfmu import Fmi2Causality, Fmi2Slave, Integer, Real


class Made{number}(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.value, self.count, self.gain = {start}, 0, {gain}
        self.register_variable(Real("value", causality=Fmi2Causality.output))
        self.register_variable(Integer("count", causality=Fmi2Causality.output))
        self.register_variable(Real("gain", causality=Fmi2Causality.local))

    def do_step(self, current_time, step_size):
        self.value += step_size * (self.gain * self.value + current_time)
        self.count += 1
        return True
"""


def checkout(name: str) -> Path:
    """The folder of a project's checkout."""
    folder = FOLDER / name
    if not folder.is_dir():
        FOLDER.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            ["git", "clone", "--quiet", "--depth", "1", SOURCES[name], str(folder)], check=True
        )
    return folder


def foreign_fmus(scratch: Path) -> list[Path]:
    """Every co-simulation FMU for Linux that there is, each content once, in the order of names."""
    found = [path for name in ("OMSimulator", "libcosim") for path in checkout(name).rglob("*.fmu")]
    found += reference_fmus(scratch)
    found += python_fmus(scratch)
    by_content: dict[str, Path] = {}
    for path in sorted(found):
        if is_usable(path):
            by_content.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path)
    return list(by_content.values())


def is_usable(path: Path) -> bool:
    """For co-simulation by FMI 2.0 or 3.0, with a library for Linux."""
    try:
        with zipfile.ZipFile(path) as archive:
            text = archive.read("modelDescription.xml").decode(errors="replace")
            names = archive.namelist()
    except (zipfile.BadZipFile, KeyError, OSError):
        return False
    here = any(n.startswith(("binaries/linux64/", "binaries/x86_64-linux/")) for n in names)
    return here and "<CoSimulation" in text and 'fmiVersion="1' not in text


def reference_fmus(scratch: Path) -> list[Path]:
    """The Reference FMUs of both versions, compiled here."""
    sources = checkout("Reference-FMUs")
    return [
        build(sources, model, version, scratch)
        for version in (2, 3)
        for model in model_names(sources, version)
    ]


def imperfect(path: Path, to: Path) -> Path:
    """The same FMU with an attribute in its description that the standard does not know."""
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(to, "w") as new:
        for entry in old.infolist():
            content = old.read(entry)
            if entry.filename == "modelDescription.xml":
                content = content.replace(
                    b"<fmiModelDescription", b'<fmiModelDescription colour="red"', 1
                )
            new.writestr(entry, content)
    return to


def python_fmus(scratch: Path, count: int = 12) -> list[Path]:
    """FMUs of PythonFMU, one for each pair of gain and start."""
    made: list[Path] = []
    for number in range(count):
        script = scratch / f"made{number}.py"
        text = PYTHON_FMU.format(number=number, start=0.5 + number, gain=-0.25 * number)
        script.write_text(text)
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(
                ["pythonfmu", "build", "-f", str(script), "-d", folder],
                check=True,
                capture_output=True,
            )
            (archive,) = Path(folder).glob("*.fmu")
            made.append(archive.replace(scratch / f"made{number}.fmu"))
    return made
