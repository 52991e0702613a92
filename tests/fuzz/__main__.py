"""``uv run --group fuzz python -m tests.fuzz``: atheris on every target, 60 s each.

Every target runs in a process of its own, because the fuzzer never returns. Exit status 1 where one
was broken; the input that did it is printed and kept.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

from tests.support.scratch import scratch_folder

PLACE = Path(__file__).parent
LONGEST_INPUT = 2048


def main() -> int:
    """Run the targets that were asked for, one after the other."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("targets", nargs="*", help="targets to run [default: all]")
    parser.add_argument("--seconds", type=int, default=60, help="for each target [default: 60]")
    parser.add_argument("--corpus", type=Path, help="keep what was found here and begin with it")
    parser.add_argument("--fuzz-one", action="store_true", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    corpus = chosen.corpus or scratch_folder("fuzz")
    if chosen.fuzz_one:
        _fuzz(chosen.targets[0], chosen.seconds, corpus)
    return _run_all(chosen.targets, chosen.seconds, corpus)


def _run_all(names: list[str], seconds: int, corpus: Path) -> int:
    from tests.fuzz.targets import TARGETS

    unknown = sorted(set(names) - set(TARGETS))
    if unknown:
        print(f"there is no target {', '.join(unknown)}; there are {', '.join(TARGETS)}")
        return 2
    broken = 0
    print(f"{'target':20}{'executions':>12}{'a second':>10}{'coverage':>10}{'corpus':>8}  outcome")
    for name in names or TARGETS:
        command = [sys.executable, "-m", "tests.fuzz", name, "--fuzz-one"]
        ended = subprocess.run(
            [*command, "--seconds", str(seconds), "--corpus", str(corpus)],
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        broken += ended.returncode != 0
        _report(name, ended)
    return 1 if broken else 0


def _report(name: str, ended: subprocess.CompletedProcess[str]) -> None:
    text = ended.stderr
    executions = _last(r"stat::number_of_executed_units: (\d+)", text)
    rate = _last(r"stat::average_exec_per_sec:\s+(\d+)", text)
    coverage, corpus = _last(r"cov: (\d+)", text), _last(r"corp: (\d+)", text)
    outcome = "ok" if ended.returncode == 0 else f"BROKEN (status {ended.returncode})"
    print(f"{name:20}{executions:>12}{rate:>10}{coverage:>10}{corpus:>8}  {outcome}", flush=True)
    if ended.returncode != 0:
        print("\n".join([*ended.stdout.splitlines()[-20:], *text.splitlines()[-25:]]), flush=True)


def _last(pattern: str, text: str) -> str:
    found = re.findall(pattern, text)
    return found[-1] if found else "?"


def _fuzz(name: str, seconds: int, corpus: Path) -> None:
    """Never returns."""
    import atheris

    with atheris.instrument_imports(include=["hil", "cosim"]):
        from tests.fuzz.targets import SEEDS, TARGETS

    folder = corpus / name
    folder.mkdir(parents=True, exist_ok=True)
    for number, seed in enumerate(SEEDS.get(name, ())):
        (folder / f"seed-{number}").write_bytes(seed)
    atheris.Setup(
        [
            name,
            f"-max_total_time={seconds}",
            f"-max_len={LONGEST_INPUT}",
            "-print_final_stats=1",
            "-len_control=0",
            f"-artifact_prefix={corpus}/{name}-",
            str(folder),
        ],
        TARGETS[name],
    )
    atheris.Fuzz()


if __name__ == "__main__":
    sys.exit(main())
