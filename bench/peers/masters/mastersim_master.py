"""MasterSim's Gauss-Jacobi algorithm at a fixed step; its program is named by ``MASTERSIM``.

It has no interface but files: its own clock is read from its summary, and the last values from its
table, which has fewer digits than a number: what agrees to its last digit is taken as the same.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

from given import CannotError, System, serve


def project(system: System, record: Path | None) -> str:
    end = (system.ticks - 1) * system.step
    lines = [
        "tStart 0 s",
        f"tEnd {end!r} s",
        *(f"{name} {system.step!r} s" for name in ("hMax", "hStart")),
        "hMin 1e-9 s",
        "hFallBackLimit 1e-9 s",
        f"hOutputMin {system.step if record else end!r} s",
        "adjustStepSize no",
        "absTol 1e-6",
        "relTol 1e-6",
        "MasterMode GAUSS_JACOBI",
        "ErrorControlMode NONE",
        "maxIterations 1",
        "writeInternalVariables no",
    ]
    lines += [
        f'simulator {number} 0 {part["name"]} #ff8c00 "{part["path"]}"'
        for number, part in enumerate(system.parts)
    ]
    lines += [f"graph {a}.{x} {b}.{y}" for a, x, b, y, _ in system.joins]
    for part in system.parts:
        for name, (kind, value) in part["start"].items():
            text = str(value).lower() if kind == "Boolean" else repr(value)
            lines.append(f"parameter {part['name']}.{name} {text}")
    return "\n".join(lines) + "\n"


def run(system: System, record: Path | None) -> tuple[float, list[float]]:
    system.need_one_rate("MasterSim")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "system.msim").write_text(project(system, record))
        done = subprocess.run(
            [os.environ["MASTERSIM"], "--verbosity-level=0", "-x", "system.msim"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            stdin=subprocess.DEVNULL,
        )
        if done.returncode:
            raise CannotError(f"it failed: {(done.stderr or done.stdout).strip()[-160:]}")
        summary = (folder / "system/log/summary.txt").read_text()
        table = next((folder / "system/results").glob("values.csv")).read_text().splitlines()
    seconds = float(summary.split("WallClockTime=")[1].split()[0])
    columns = [column.split(" [")[0] for column in table[0].split("\t")]
    last = dict(zip(columns, table[-1].split("\t"), strict=True))
    values = [float(last[f"{part}.{variable}"]) for part, variable, _ in system.watched]
    return seconds * system.ticks / (system.ticks - 1), values


if __name__ == "__main__":
    serve(run)
