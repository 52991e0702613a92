"""Scenarios with the kernel and all of our FMUs compiled by gcc, for tools that watch a process.

``build`` makes what ``python -m tests.support.fmus.watched FOLDER`` runs: with gcc's sanitizers, in
a process with their library loaded first, or without, under valgrind.
"""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path

import fmus
from cosim.master.kernel import build as kernel_build
from fmus.builder import FOLDER, model_files, source_of, support_files
from fmus.compiler import host_platform
from fmus.header import description_source, variables_header
from tests.support.fmus.hosted import GLUE

FLAGS = ("-std=gnu11", "-O1", "-g", "-fPIC", "-shared", "-ffp-contract=off", "-fno-math-errno")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
KERNEL = "kernel.so"
FREESTANDING = ("runtime.c",)
"""Of the kernel: what a program has of its C library, where it has one."""
TICKS = 320


def build(folder: Path, watching: Sequence[str] = ()) -> None:
    """The kernel, and an archive of each model and flavour, in ``folder``; with gcc's options."""
    build_kernel(folder, watching)
    for name in fmus.model_names():
        _compile_model(name, folder, watching)


def build_kernel(folder: Path, watching: Sequence[str] = (), more: Sequence[Path] = ()) -> None:
    """The kernel alone, with ``more`` C files."""
    sources = [path for path in kernel_build.SOURCES.glob("*.c") if path.name not in FREESTANDING]
    options = [*watching, f"-I{kernel_build.SOURCES}"]
    _compile(folder / KERNEL, options, [*sources, *more])


def _compile_model(name: str, folder: Path, watching: Sequence[str]) -> None:
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
    options = [
        *watching,
        "-DCOHAPTIC_HOSTED",
        "-fno-builtin",
        *(f"-I{each}" for each in include),
        "-lm",
    ]
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
    command = ["gcc", *FLAGS, *map(str, files), *options, "-o", str(library)]
    subprocess.run(command, check=True)


def main() -> None:
    """Every bundled scenario for some ticks; its name is said when it is done."""
    from cosim.analysis import load_tuned
    from cosim.base.recording import MemorySink
    from cosim.master.run.simulation import Simulation, assemble
    from cosim.reading import FORMS
    from cosim.scenario.source.find import bundled_names

    def run_and_restore(simulation: Simulation) -> None:
        def again() -> None:
            simulation.restore(simulation.snapshot())

        simulation.run(MemorySink(), until=TICKS, pauses={TICKS // 2: again})

    folder = Path(sys.argv[1])
    kernel_build.find_kernel = lambda: folder / KERNEL
    fmus.find = lambda name, flavour="fmi3": folder / f"{name}.{flavour}.fmu"
    for name in bundled_names():
        if name.startswith(("presets/", "devices/")):
            continue
        with assemble(load_tuned(name, forms=FORMS)) as simulation:
            run_and_restore(simulation)
        print(name, flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
