"""FMUs that end their process, by the command line; ``failing`` has every call and every way."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from cosim.record.reader import open_run
from tests.support.fmus.foreign import foreign_fmu, scalar

TICKS = 8
EARLY = "before the first tick; nothing was recorded"
WHOLE = f"at tick {TICKS} ({TICKS} s); the record is complete"
CALLS = {
    "Instantiate": (EARLY, "in {name} "),
    "EnterInitializationMode": (EARLY, "in {name} "),
    "ExitInitializationMode": (EARLY, "in {name} "),
    "DoStep": ("in its step at tick 3 (3 s); what was written before is kept", ""),
    "Terminate": (WHOLE, "in {name} "),
}


def dying(folder: Path, version: int, call: str, code: str, rate: int = 1) -> Path:
    """An FMU that does ``code`` in a call of the standard, in its steps at tick 3 of ``rate``."""
    name = {"initial Get": {2: "GetReal", 3: "GetFloat64"}[version]}.get(call, call)
    late = {"DoStep": f"m->time > {2.5 / rate}"}
    snippet = f"""
        void exit(int); void _exit(int); void abort(void); int raise(int); int pause(void);
        static int hook(Foreign *m, const char *call)
        {{
            if (is(call, "{name}") && {late.get(call, "1")})
                {code};
            return 0;
        }}
        #define HOOK hook
    """
    variables = (
        scalar(version, "u", 1, causality="input", start="0")
        + scalar(version, "y", 2, causality="output")
        + scalar(
            version, "p", 3, "String", '<Start value="x"/>' if version == 3 else "",
            causality="parameter", variability="fixed", **({"start": "x"} if version == 2 else {}),
        )
    )  # fmt: skip
    structure = '<Output valueReference="2" dependencies=""/>'
    if version == 2:
        structure = '<Outputs><Unknown index="2" dependencies=""/></Outputs>'
    return foreign_fmu(folder, version, variables, snippet=snippet, structure=structure)


def command(folder: Path, fmu: Path, *options: str, rate: int = 1, keys: str = "") -> list[str]:
    """Write ``test.yaml``, where the FMU is ``box``; the command that runs it into ``out``."""
    more = f", feedthrough: true, parameters: {{p: text}}{keys}"
    (folder / "test.yaml").write_text(
        f"cohaptic: 1\nduration: {TICKS / rate}\nbase_rate: {rate}\ncomponents:\n"
        f"  hand: {{fmu: hand, rate: {rate}}}\n"
        f"  box: {{fmu: {fmu}, rate: {rate}{more}}}\n"
        "connections: [hand.position -> box.u]\n"
    )
    run = "from cosim.cli import main; main()"
    arguments = ("run", "test.yaml", "--out", "out", "--no-figure", *options)
    return [sys.executable, "-c", run, *arguments]


def ended(
    folder: Path, fmu: Path, *options: str, rate: int = 1, keys: str = ""
) -> subprocess.CompletedProcess[str]:
    """What ``command`` did."""
    return subprocess.run(
        command(folder, fmu, *options, rate=rate, keys=keys),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def sentence(call: str, version: int, rate: int = 1) -> tuple[str, str]:
    """Where ``box`` died by ``dying``, and what of the record there is."""
    place, of_the_standard = CALLS[call]
    full = {("Instantiate", 3): "InstantiateCoSimulation"}.get((call, version), call)
    name = of_the_standard.format(name=f"fmi{version}{full}")
    for tick in (3, TICKS):
        place = place.replace(f"tick {tick} ({tick} s)", f"tick {tick} ({tick / rate:g} s)")
    return name + place, place


def record_is_right(folder: Path, place: str, said: str) -> None:
    """Finished in the way that the sentence says, with status 1."""
    out = folder / "out"
    if "nothing was recorded" in place:
        assert not out.exists()
        return
    summary = json.loads((out / "summary.json").read_text())
    manifest = json.loads((out / "manifest.json").read_text())
    assert summary["status"] == manifest["exit"]["status"] == 1
    assert summary["message"] == manifest["exit"]["message"]
    assert summary["message"] in said
    with open_run(out) as run:
        assert run.ticks == TICKS if "complete" in place else run.ticks <= 4
        assert all(group.capacity == group.rows for group in run.groups.values())
