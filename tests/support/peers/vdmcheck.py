"""VDMCheck, compiled from its sources: a formal model (VDM-SL) of the rules of FMI 2.0 and 3.0.

https://github.com/INTO-CPS-Association/FMI-VDM-Model, interpreted by VDMJ 4.5
(https://github.com/nickbattle/vdmj, tag ``4.5.0-release``). It checks with the schema of 3.0.0.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

_QUESTION = "isValidFMIConfigurations(modelDescription, buildDescription, terminalsAndIcons)"


class VdmCheck:
    """The checker in ``folder``, from checkouts of the rules and of the interpreter.

    Raises:
        subprocess.CalledProcessError: the compiler refuses the sources.
    """

    def __init__(self, rules: Path, interpreter: Path, folder: Path) -> None:
        self._folder = folder
        classes = folder / "classes"
        sources = [
            path
            for root in (
                interpreter / "vdmj",
                interpreter / "annotations",
                rules / "xsd2vdm",
                rules / "fmuReader",
            )
            for path in (root / "src" / "main" / "java").rglob("*.java")
        ]
        command = ["javac", "-nowarn", "-encoding", "UTF-8", "-d", classes, *sources]
        subprocess.run(command, check=True, capture_output=True)
        # Files of one name stand in several of them, and all of them are read.
        parts = (interpreter / "vdmj", interpreter / "annotations", rules / "fmuReader")
        resources = [part / "src" / "main" / "resources" for part in parts]
        self._path = os.pathsep.join(map(str, (classes, *resources)))
        for version in (2, 3):
            schemas = rules / f"fmi{version}" / "vdmcheck" / "src" / "main" / "resources"
            shutil.copytree(schemas / f"fmi{version}schema", folder / f"fmi{version}schema")
            shutil.copytree(rules / f"fmi{version}" / "rule-model", folder / f"rules{version}")
            shutil.rmtree(folder / f"rules{version}" / "Tests")

    def judge(self, fmu: Path, version: int) -> str:
        """What it prints of an FMU or a description: ``true`` alone where no rule is broken."""
        rules = self._folder / f"rules{version}"
        command = [
            "java",
            "-Dvdmj.parser.merge_comments=true",
            "-Dfmureader.noschema=true",
            f"-Dfmureader.xsd=fmi{version}schema/fmi{version}.xsd",
            "-cp",
            self._path,
            *("com.fujitsu.vdmj.VDMJ", "-vdmsl", "-q", "-annotations", "-e", _QUESTION),
            str(rules),
            *map(str, sorted((rules / "Rules").glob("*.adoc"))),
            str(fmu),
        ]
        done = subprocess.run(
            command, cwd=self._folder, capture_output=True, check=False, text=True
        )
        return (done.stdout + done.stderr).strip()
