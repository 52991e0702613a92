"""The master against a bare C loop over the same FMUs, in one interleaved run.

    uv run python bench/kernel.py [SCENARIO|ring:N] [--seconds 10] [--rounds 5]

The bare loop is straight-line C, written out for the scenario and compiled here: every address,
value reference and count is a constant in it; it checks no value, records nothing and cannot be
stopped. Both run in slices of 1024 ticks, one after the other, so that whatever else the machine
does hits both, and what is counted is the thread's processor time; in the end all variables of all
FMUs must agree bit for bit. ``ring:8`` is a ring of eight light FMUs. What the master records is
kept in memory; then both loops write it to a binary log instead, the bare one through ``fwrite``,
and both files must be the same, byte for byte.
"""

from __future__ import annotations

import argparse
import ctypes
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from binary_logs import BareLog, BinaryLog  # beside this file

from cosim.base.recording import MemorySink
from cosim.master.kernel.codes import OperationKind
from cosim.master.kernel.structures import OperationStruct
from cosim.master.run.simulation import Simulation, assemble
from cosim.scenario import Scenario, load
from cosim.testing.ring import row_of_masses
from fmus.compiler import compile_library, host_platform

SLICE = 1024
C_TYPES = {
    1: "float",
    2: "int8_t",
    3: "uint8_t",
    4: "int16_t",
    5: "uint16_t",
    6: "int32_t",
    7: "uint32_t",
    8: "int64_t",
    9: "uint64_t",
    10: "bool",
    11: "int32_t",
}
HEAD = """
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
typedef union { double r; int64_t i; } Cell;
typedef int (*A2)(void *, const uint32_t *, size_t, void *);
typedef int (*A3)(void *, const uint32_t *, size_t, void *, size_t);
typedef size_t (*W)(const void *, size_t, size_t, void *);
typedef int (*S2)(void *, double, double, int);
typedef int (*S3)(void *, double, double, bool, bool *, bool *, bool *, double *);
#define P(TYPE, ADDRESS) ((TYPE)(uintptr_t)(ADDRESS))
static Cell *const c = (Cell *)(uintptr_t)%dULL;
void *memcpy(void *restrict a, const void *restrict b, size_t n)
{ for (size_t i = 0; i < n; i++) ((volatile char *)a)[i] = ((const char *)b)[i]; return a; }
void *memset(void *a, int v, size_t n)
{ for (size_t i = 0; i < n; i++) ((volatile char *)a)[i] = (char)v; return a; }
"""


def pairs(operation: OperationStruct, count: int) -> list[tuple[int, int]]:
    """The cells that a copy goes from and to."""
    table = ctypes.cast(operation.table, ctypes.POINTER(ctypes.c_int32))
    return [(table[2 * i], table[2 * i + 1]) for i in range(count)]


def copies(operation: OperationStruct, count: int) -> str:
    return " ".join(f"c[{b}] = c[{a}];" for a, b in pairs(operation, count))


def logged(operation: OperationStruct, log: BareLog | None) -> str:
    if log is None:
        return ""
    count = operation.cell_count
    columns = ctypes.cast(operation.table, ctypes.POINTER(ctypes.c_int32))
    row = " ".join(f"row[{i}] = c[{columns[i]}];" for i in range(count))
    stream = log.streams[operation.owner]
    call = f"P(W, {log.fwrite}ULL)(row, 8, {count}, P(void *, {stream}ULL));"
    return f"Cell row[{count}]; {row} {call}"


def statements(simulation: Simulation, log: BareLog | None) -> list[str]:
    """One statement an operation of an ordinary tick."""
    program = simulation.program
    base = program.cells.ctypes.data
    written: list[str] = []
    operations = zip(program.operations.all, program.operations.actions, strict=True)
    for number, (operation, action) in enumerate(operations):
        if number in program.early:
            continue
        text = statement(simulation, operation, base, log)
        if not text:
            continue
        guard = f"if (k % {action.period} == 0) " if action.period > 1 else ""
        written.append(f"{guard}{{ {text} }}")
    return written


def statement(
    simulation: Simulation, operation: OperationStruct, base: int, log: BareLog | None
) -> str:
    """What the bare loop does in place of one operation."""
    kind = OperationKind(operation.kind)
    if kind is OperationKind.COPY:
        return copies(operation, operation.cell_count)
    if kind in {
        OperationKind.SET,
        OperationKind.GET,
        OperationKind.SET_FLOAT64,
        OperationKind.GET_FLOAT64,
    }:
        return access(simulation, operation, kind, (operation.cells - base) // 8)
    if kind in {OperationKind.STEP, OperationKind.STEP_IN_PARTS}:
        return step(simulation, operation)
    if kind in {OperationKind.DELIVER, OperationKind.SAMPLE, OperationKind.SEND}:
        return packet(simulation, operation, kind)
    if kind is OperationKind.RECORD:
        return logged(operation, log)
    raise SystemExit(f"the bare loop cannot do {kind.name}: choose a scenario of FMUs only")


def access(
    simulation: Simulation, operation: OperationStruct, kind: OperationKind, first: int
) -> str:
    instance = simulation.program.instances[operation.owner].instance
    n, values = operation.reference_count, operation.cell_count
    direct = kind in {OperationKind.SET_FLOAT64, OperationKind.GET_FLOAT64}
    buffer = f"c + {first}" if direct else f"P(void *, {operation.scratch}ULL)"
    more = f", {values}" if operation.version == 3 else ""
    call = (
        f"s |= P(A{operation.version}, {operation.function}ULL)(P(void *, {instance}ULL), "
        f"P(const uint32_t *, {operation.references}ULL), {n}, {buffer}{more});"
    )
    if direct:
        return f"{copies(operation, operation.copy_count)} {call}"
    kind_name, field = C_TYPES[operation.type], "r" if operation.type == 1 else "i"
    scratch = f"P({kind_name} *, {operation.scratch}ULL)"
    loop = f"for (int j = 0; j < {values}; j++)"
    if kind is OperationKind.SET:
        return f"{loop} {scratch}[j] = ({kind_name})c[{first} + j].{field}; {call}"
    return f"{call} {loop} c[{first} + j].{field} = {scratch}[j];"


def step(simulation: Simulation, operation: OperationStruct) -> str:
    instance = simulation.program.instances[operation.owner]
    tick = simulation.assembly.clock.seconds(1)
    head = f"P(void *, {instance.instance}ULL)"
    lines: list[str] = []
    for j in range(instance.substeps):
        time_text = f"k * {tick!r} + {j * instance.step!r}"
        if instance.version == 2:
            call = f"P(S2, {instance.do_step}ULL)({head}, {time_text}, {instance.step!r}, 1)"
        else:
            call = (
                f"P(S3, {instance.do_step}ULL)({head}, {time_text}, {instance.step!r}, true, "
                "&e, &x, &y, &z)"
            )
        lines.append(f"s |= {call};")
    return " ".join(lines)


def packet(simulation: Simulation, operation: OperationStruct, kind: OperationKind) -> str:
    """A constant delay, as a ring that is as long as it has to be."""
    number = operation.owner
    bundle = simulation.assembly.wiring.bundles[number]
    if not bundle.fates.is_constant:
        raise SystemExit("the bare loop knows no loss or jitter: choose a channel without")
    layout = simulation.assembly.layout
    delay, period, width = bundle.fates.shortest, bundle.period, len(bundle.entries)
    slots = delay // period + 1
    sources = [layout.of(entry.source) for entry in bundle.entries]
    held = layout.held[number]
    if kind is OperationKind.SAMPLE:
        return copies(operation, operation.cell_count)
    if kind is OperationKind.SEND:
        if delay == 0:
            return ""
        row = f"ring{number} + (k / {period}) % {slots} * {width}"
        packed = " ".join(f"q[{i}] = c[{source}];" for i, source in enumerate(sources))
        return f"Cell *q = {row}; {packed}"
    age, sequence = layout.age[number], layout.sequence[number]
    if delay == 0:
        return f"c[{age}].i = k % {period}; if (k % {period} == 0) c[{sequence}].i = k / {period};"
    row = f"ring{number} + ((k - {delay}) / {period}) % {slots} * {width}"
    unpacked = " ".join(f"c[{held + i}] = q[{i}];" for i in range(width))
    return (
        f"if (k >= {delay} && (k - {delay}) % {period} == 0) {{ const Cell *q = {row}; {unpacked} "
        f"c[{sequence}].i = (k - {delay}) / {period}; c[{age}].i = {delay}; }} "
        f"else c[{age}].i += k > 0;"
    )


def compile_bare(
    simulation: Simulation, folder: Path, log: BareLog | None = None
) -> Callable[[int, int], int]:
    """The bare loop over ticks [k, end) of a simulation that has been started."""
    body = "\n".join(statements(simulation, log))
    rings = "\n".join(
        f"static Cell ring{number}[{(b.fates.shortest // b.period + 1) * len(b.entries)}];"
        for number, b in enumerate(simulation.assembly.wiring.bundles)
        if b.fates.shortest > 0
    )
    base = simulation.program.cells.ctypes.data
    source = folder / "bare.c"
    source.write_text(
        HEAD % base
        + rings
        + '\n__attribute__((visibility("default"))) int bare(int64_t k, int64_t end)\n{\n'
        + "int s = 0; bool e, x, y; double z; (void)e; (void)x; (void)y; (void)z;\n"
        + "for (; k < end; k++) {\n"
        + body
        + "\n}\nreturn s;\n}\n"
    )
    target = host_platform()
    library = folder / f"bare{target.suffix}"
    compile_library(target, library, [source])
    function = ctypes.CDLL(str(library)).bare
    function.argtypes = (ctypes.c_int64, ctypes.c_int64)
    return function


def measure(
    scenario: Scenario, folder: Path, *, recorded: bool, log: bool = False
) -> tuple[float, float]:
    """Processor time (s) of the master's loop and of the bare loop."""
    written = scenario if recorded else replace(scenario, record=())
    ticks = scenario.ticks
    with assemble(written) as bare_run, assemble(written) as master_run:
        for simulation in (bare_run, master_run):
            simulation.start(ticks, recorded=recorded)
        files = [
            [folder / f"{who}_{number}.log" for number in range(len(master_run.groups))]
            for who in ("master", "bare")
        ]
        bare_log = BareLog(files[1]) if log else None
        master_log = BinaryLog(files[0]) if log else None
        sink = master_log or (MemorySink() if recorded else None)
        if sink is not None:
            sink.begin(master_run.groups, scenario.base_rate)
        bare = compile_bare(bare_run, folder, bare_log)
        master_time = bare_time = 0.0
        for begin in range(0, ticks, SLICE):
            end = min(ticks, begin + SLICE)
            t0 = time.thread_time()
            master_run.advance(end, sink)
            t1 = time.thread_time()
            status = bare(begin, end)
            t2 = time.thread_time()
            master_time, bare_time = master_time + t1 - t0, bare_time + t2 - t1
            assert status <= 1
        variables = min([*master_run.assembly.layout.held, len(master_run.program.cells)])
        agree = np.array_equal(
            master_run.program.cells[:variables], bare_run.program.cells[:variables]
        )
        for each in (bare_log, master_log):
            if each is not None:
                each.close()
        if log:
            agree = agree and all(
                ours.read_bytes() == theirs.read_bytes()
                for ours, theirs in zip(*files, strict=True)
            )
        if not agree:
            raise SystemExit("the two loops do not agree: the comparison is void")
    return master_time, bare_time


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("scenario", nargs="?", default="two_users_box")
    parser.add_argument("--seconds", default="10")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        scenario = chosen(options.scenario, options.seconds, Path(folder))
    print(f"{options.scenario}, {options.seconds} s, {scenario.ticks} ticks, slices of {SLICE}")
    for recorded, log, what in (
        (False, False, "off"),
        (True, False, "on"),
        (True, True, "on, to a binary log"),
    ):
        ratios: list[float] = []
        for _ in range(options.rounds):
            with tempfile.TemporaryDirectory() as folder:
                master, bare = measure(scenario, Path(folder), recorded=recorded, log=log)
            ratios.append(master / bare)
            per_tick = 1e6 / scenario.ticks
            print(
                f"  recording {what}: master {master * per_tick:6.2f} us a tick, "
                f"bare C {bare * per_tick:6.2f}, ratio {ratios[-1]:.3f}"
            )
        print(f"  median ratio, recording {what}: {np.median(ratios):.3f}")


def chosen(name: str, seconds: str, folder: Path) -> Scenario:
    kind, _, size = name.partition(":")
    if kind == "ring":
        file = folder / "ring.yaml"
        file.write_text(row_of_masses(int(size), ticks=round(1024 * float(seconds))))
        return load(file)
    return load(name, sets=[f"duration={seconds}"])


if __name__ == "__main__":
    main()
