"""Ratios that a release is held to, and what got slower since: ``uv run python bench/ratios.py``.

    uv run python bench/ratios.py            measure, and compare with the latest release
    uv run python bench/ratios.py --save     measure, and keep them as this version's
    uv run python bench/ratios.py --compare 0.1.0 0.2.0    nothing is measured

Each ratio is processor time over that of something bare, measured in turns, so that it says the
same on a slow or a busy machine; or it is the most memory that a process had, over that of a bare
one. Those of every release are in ``bench/ratios``. The exit status is 1 where one is worse by more
than the tolerance.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

FOLDER = Path(__file__).with_name("ratios")
TOLERANCE = 0.15
"""How much worse a ratio may be before it is said (1): rounds differ by some hundredths."""
Pair = tuple[Callable[[], object], Callable[[], object]]
"""What is judged, and the bare thing that it is measured by."""


def main() -> None:
    """Measure, keep or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=_AsWritten)
    parser.add_argument("--save", action="store_true", help="keep them as this version's")
    parser.add_argument("--compare", nargs=2, metavar=("OLD", "NEW"), help="two kept versions")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    chosen = parser.parse_args()
    if chosen.compare:
        old, new = (kept(version) for version in chosen.compare)
        sys.exit(report(old, new, chosen.tolerance))
    found = measure(chosen.rounds)
    if chosen.save:
        path = FOLDER / f"{this_version()}.json"
        path.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
        print(f"kept in {path}")
    earlier = [version for version in versions() if not (chosen.save and version == this_version())]
    sys.exit(report(kept(earlier[-1]) if earlier else {}, found, chosen.tolerance))


def report(old: Mapping[str, float], new: Mapping[str, float], tolerance: float) -> int:
    """Print every ratio beside the old one; 1 where one is worse, or is not measured any more."""
    worse = slower(old, new, tolerance)
    for name in sorted({*old, *new}):
        before, now = (_shown(each.get(name)) for each in (old, new))
        print(f"{name:44} {before:>8} {now:>8}{'  slower' if name in worse else ''}")
    for name in worse:
        print(f"{name}: {_shown(old[name])} before, {_shown(new.get(name))} now", file=sys.stderr)
    return 1 if worse else 0


def slower(old: Mapping[str, float], new: Mapping[str, float], tolerance: float) -> list[str]:
    """The ratios that are worse by more than the tolerance, or missing, the worst first."""
    worse = {
        name: new.get(name, float("inf")) / ratio
        for name, ratio in old.items()
        if new.get(name, float("inf")) > ratio * (1 + tolerance)
    }
    return sorted(worse, key=lambda name: -worse[name])


def measure(rounds: int) -> dict[str, float]:
    """Every ratio: the median of rounds in which both are measured in turn."""
    found: dict[str, float] = {}
    with ExitStack() as stack:
        for name, make in RATIOS.items():
            judged, bare = make(stack)
            judged(), bare()
            found[name] = round(statistics.median(_round(judged, bare) for _ in range(rounds)), 3)
    for name, (judged, bare) in MEMORY.items():
        found[name] = round(_memory(judged) / _memory(bare), 3)
    return found


def _round(judged: Callable[[], object], bare: Callable[[], object]) -> float:
    return _time(judged) / _time(bare)


def _time(act: Callable[[], object]) -> float:
    began = _processor_time()
    act()
    return _processor_time() - began


def _processor_time() -> float:
    """Of this process and those that it has waited for (s)."""
    import resource

    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _memory(program: str) -> int:
    """The most memory (KiB) that a process with this program had."""
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{_MOST}"], check=True, capture_output=True, text=True
    )
    return int(done.stdout.splitlines()[-1])


def _warm_runs(scenario: str, count: int) -> Callable[[ExitStack], Pair]:
    """Half seconds run again and again with their measures, over their loops alone."""

    def make(stack: ExitStack) -> Pair:
        from cosim.master.run.simulation import assemble
        from cosim.reading import FORMS
        from cosim.sweep.job import Task
        from cosim.sweep.planning.plan import Request, plan_of
        from cosim.sweep.work.runner import PointRunner
        from cosim.sweep.work.variants import Variants
        from cosim.sweep.work.worker import settle

        settle()
        sets = ["duration=0.5 s", "expect=~"]
        plan = plan_of(Request(scenario=scenario, seeds=count, sets=sets, check_every=0), FORMS)
        runner = stack.enter_context(PointRunner(plan.job))
        first = replace(Variants(plan.job).scenario(plan.points[0]), expect={})
        bare = stack.enter_context(assemble(first))
        bare.run(keep_fmus=True)

        def run() -> None:
            for number, point in enumerate(plan.points):
                assert runner.run(Task(number, point)).is_over

        def loops() -> None:
            for _ in range(count):
                bare.renew(bare.assembly)
                bare.run(keep_fmus=True)

        return run, loops

    return make


def _recorded(stack: ExitStack) -> Pair:
    """Two seconds of the box with every signal in memory, over the same with none."""
    from cosim.base.recording import MemorySink
    from cosim.master.run.simulation import assemble
    from cosim.reading import load

    scenario = replace(load("two_users_box", sets=["duration=2 s"]), expect={})
    one, other = (stack.enter_context(assemble(scenario)) for _ in range(2))
    sink = MemorySink(scenario.ticks)

    def recorded() -> None:
        one.run(sink, keep_fmus=True)
        one.renew(one.assembly)

    def plain() -> None:
        other.run(keep_fmus=True)
        other.renew(other.assembly)

    return recorded, plain


def _one_signal(stack: ExitStack) -> Pair:
    """One signal of twenty seconds opened by its name, over h5py that knows where it lies."""
    import h5py

    from cosim.reading import load
    from cosim.record import open_run
    from cosim.run import run_scenario

    folder = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "run"
    scenario = replace(load("two_users_box", sets=["duration=20 s"]), expect={})
    run_scenario(scenario, folder, figure=False)
    name = "vr_a.box_pose.y"
    with h5py.File(folder / "run.h5") as file:
        entries = [entry["name"].decode() for entry in file["control/signals"]]
        row = int(file["control/signals"][entries.index(name)]["row"])

    def by_name() -> None:
        for _ in range(20):
            with open_run(folder) as run:
                assert run[name].values.size

    def by_place() -> None:
        for _ in range(20):
            with h5py.File(folder / "run.h5", "r", rdcc_nbytes=0) as file:
                assert file["control/float64"][row].size

    return by_name, by_place


def _command(_stack: ExitStack) -> Pair:
    """The process of a check of the box, over one that imports NumPy and HDF5."""

    def start(*arguments: str) -> Callable[[], object]:
        command = [sys.executable, *arguments]
        return lambda: subprocess.run(command, check=True, capture_output=True)

    check = (
        "import sys; sys.argv[1:] = ['check', 'two_users_box']; from cosim.cli import main; main()"
    )
    return start("-c", check), start("-c", "import numpy, h5py")


RATIOS: Mapping[str, Callable[[ExitStack], Pair]] = {
    "warm half second of a single axis / loop": _warm_runs("single_axis_distributed", 200),
    "warm half second of two_users_box / loop": _warm_runs("two_users_box", 40),
    "two_users_box recorded / not recorded": _recorded,
    "one signal by name / by place": _one_signal,
    "cohaptic check / imports": _command,
}

_MOST = """
import pathlib
print(*(line.split()[1] for line in pathlib.Path("/proc/self/status").read_text().splitlines()
        if line.startswith("VmHWM")))
"""
"""Not ``ru_maxrss``, which begins with what the process had that started this one."""
_RECORDED = """
import tempfile, cohaptic
with tempfile.TemporaryDirectory() as folder:
    sets = ["duration={} s", "expect=~"]
    cohaptic.run("two_users_box", f"{{folder}}/run", sets=sets, figure=False)
"""
_RING = """
import tempfile, pathlib
from cosim.master.run.simulation import assemble
from cosim.scenario import load
from cosim.testing.ring import ring_scenario
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "ring.yaml"
    file.write_text(ring_scenario(512, record="[]"))
    assemble(load(file)).close()
"""
MEMORY: Mapping[str, tuple[str, str]] = {
    "memory: two_users_box recorded, 60 s / 5 s": (_RECORDED.format(60), _RECORDED.format(5)),
    "memory: a ring of 512 assembled / imports": (_RING, "import numpy, h5py"),
}
"""What is judged, and the bare program that it is measured by."""


def versions() -> list[str]:
    """The releases that ratios are kept of, the oldest first."""
    names = [path.stem for path in FOLDER.glob("*.json")]
    return sorted(names, key=lambda name: [int(part) for part in name.split(".")])


def kept(version: str) -> dict[str, float]:
    """The ratios of a release."""
    path = FOLDER / f"{version}.json"
    if not path.is_file():
        sys.exit(f"there are no ratios of {version}; there are those of {', '.join(versions())}.")
    return json.loads(path.read_text(encoding="utf-8"))


def this_version() -> str:
    """Of the package that is installed, without what marks it as not released yet."""
    from importlib.metadata import version

    numbers = version("cohaptic").split(".")[:3]
    return ".".join("".join(c for c in part if c.isdigit()) or "0" for part in numbers)


def _shown(ratio: float | None) -> str:
    return "none" if ratio is None else f"{ratio:.2f}"


class _AsWritten(argparse.RawDescriptionHelpFormatter):
    """Keeps the lines of the text above."""


if __name__ == "__main__":
    main()
