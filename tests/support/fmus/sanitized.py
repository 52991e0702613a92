"""Scenarios with the kernel and all of our FMUs compiled by gcc with its sanitizers.

``python -m tests.support.fmus.sanitized FOLDER`` in a process with the sanitizers' library loaded
first; ``build`` makes what it runs. A complaint ends the process with the sanitizers' status.
"""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import fmus
from cosim.master.kernel import build as kernel_build
from fmus.builder import FOLDER, model_files, source_of, support_files
from fmus.compiler import host_platform
from fmus.header import description_source, variables_header

FLAGS = ("-std=gnu11", "-O1", "-g", "-fPIC", "-shared", "-ffp-contract=off", "-fno-math-errno")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
GLUE = ("instance.c", "values.c", "snapshot.c", "fmi2.c", "fmi3.c")
KERNEL = "kernel.so"
TICKS = 320


def build(folder: Path) -> None:
    """The kernel, and an archive of each model and flavour, in ``folder``."""
    sources = [path for path in kernel_build.SOURCES.glob("*.c") if path.name != "runtime.c"]
    _compile(folder / KERNEL, [f"-I{kernel_build.SOURCES}"], sources)
    for name in fmus.model_names():
        _compile_model(name, folder)


def _compile_model(name: str, folder: Path) -> None:
    source = source_of(name)
    flavours = ("fmi2", "fmi3", "fmi3-arrays")
    archives = {flavour: fmus.find(name, flavour) for flavour in flavours}
    (folder / f"{name}_variables.h").write_text(variables_header(source.model))
    description = folder / f"{name}_description.c"
    token = _token(archives["fmi3"])
    description.write_text(description_source(source.model, token=token, digest="0" * 64))
    include = [FOLDER / each for each in ("fmi", "fmi/headers", "libm", "libm/musl")]
    shared = sorted(each for each in (FOLDER / "shared").iterdir() if each.is_dir())
    include += [*shared, source.folder, folder]
    library = folder / f"{name}.so"
    files = [description, *model_files(source), *support_files()]
    files += [FOLDER / "fmi" / each for each in GLUE]
    options = ["-DCOHAPTIC_HOSTED", "-fno-builtin", *(f"-I{each}" for each in include), "-lm"]
    _compile(library, options, files)
    for flavour, archive in archives.items():
        _with_library(archive, library, folder / archive.name, flavour)


def _token(archive: Path) -> str:
    with zipfile.ZipFile(archive) as opened:
        text = opened.read("modelDescription.xml").decode()
    return text.split('instantiationToken="', 1)[1].split('"', 1)[0]


def _with_library(archive: Path, library: Path, to: Path, flavour: str) -> None:
    host = host_platform()
    platform = host.fmi2 if flavour == "fmi2" else host.name
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(to, "w") as new:
        for entry in old.namelist():
            mine = entry == f"binaries/{platform}/{library.name}"
            new.writestr(entry, library.read_bytes() if mine else old.read(entry))


def _compile(library: Path, options: list[str], files: list[Path]) -> None:
    command = ["gcc", *SANITIZERS, *FLAGS, *map(str, files), *options, "-o", str(library)]
    subprocess.run(command, check=True)


def main() -> None:
    """Every bundled scenario for some ticks; its name is said when it is done."""
    from cosim.analysis import load_tuned
    from cosim.base.recording import MemorySink
    from cosim.master.run.simulation import assemble
    from cosim.reading import FORMS
    from cosim.scenario.source.find import bundled_names

    folder = Path(sys.argv[1])
    kernel_build.find_kernel = lambda: folder / KERNEL
    fmus.find = lambda name, flavour="fmi3": folder / f"{name}.{flavour}.fmu"
    for name in bundled_names():
        if name.startswith(("presets/", "devices/")):
            continue
        with assemble(load_tuned(name, forms=FORMS)) as simulation:
            simulation.run(MemorySink(), until=TICKS)
        print(name, flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
