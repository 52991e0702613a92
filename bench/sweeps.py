"""What repeating runs costs beside the loops themselves: ``python bench/sweeps.py``.

Bare loops and sweeps take turns, each on every processor, so that other load hits both alike. The
bare sum of loops over the processors is what no sweep can beat. On a machine that has other work to
do the processor times say more: of the workers and of the process that feeds them, over that of the
loops.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

from cosim.master.run.simulation import assemble
from cosim.reading import FORMS
from cosim.sweep.job import Task
from cosim.sweep.planning.plan import Request, SweepPlan, plan_of
from cosim.sweep.work.pool import LocalPool, processors
from cosim.sweep.work.runner import PointRunner
from cosim.sweep.work.worker import settle

BOX, AXIS = "two_users_box", "single_axis_distributed"


@dataclass(frozen=True, slots=True)
class Cost:
    """What some runs took."""

    wall: float
    used: float
    """Processor time (s), of all processes together."""


def bare(scenario: str, runs: int) -> Cost:
    """The loops alone: FMUs reset between them, nothing recorded, nothing looked at.

    Their processor time is their share of what this process used.
    """
    plan = plan_for(scenario, 1)
    runner_scenario = replace(_first(plan), expect={})
    total = 0.0
    with assemble(runner_scenario) as simulation:
        simulation.run(keep_fmus=True)
        wall, used = time.perf_counter(), time.process_time()
        for _ in range(runs):
            simulation.renew(simulation.assembly)
            simulation.run(keep_fmus=True)
            total += simulation.outcome.wall_time
        wall, used = time.perf_counter() - wall, time.process_time() - used
    return Cost(total, used * total / wall)


def bare_everywhere(scenario: str, runs: int, workers: int) -> Cost:
    """What the loops alone of so many runs take, spread over processes."""
    command = [sys.executable, __file__, "--bare", scenario, str(runs // workers)]
    started = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(workers)]
    found = [Cost(*map(float, process.communicate()[0].split())) for process in started]
    return Cost(sum(each.wall for each in found) / workers, sum(each.used for each in found))


def plan_for(scenario: str, runs: int, **more: object) -> SweepPlan:
    given = {"sets": ["duration=0.5 s", "expect=~"], "check_every": 100, "seeds": runs, **more}
    return plan_of(Request(scenario=scenario, **given), FORMS)  # type: ignore[arg-type]


def swept(plan: SweepPlan, pool: LocalPool, numbers: range) -> Cost:
    """What these points take in a pool whose workers are up."""
    began, used = time.perf_counter(), _used(pool)
    tasks = (Task(number, plan.points[number], str(number)) for number in numbers)
    results = list(pool.run(tasks))
    bad = next((result for result in results if not result.is_over), None)
    assert bad is None, bad
    return Cost(time.perf_counter() - began, _used(pool) - used)


def _used(pool: LocalPool) -> float:
    """Processor time (s) of the workers and of this process."""
    ticks = 0
    for process in pool.processes:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK") + time.process_time()


def compare(
    title: str, scenario: str, runs: int, workers: int, rounds: int, **more: object
) -> None:
    plan = plan_for(scenario, runs, **more)
    has_bare = "start" not in more
    part = runs // rounds
    ratios: list[float] = []
    sums = [0.0, 0.0]
    used = [0.0, 0.0]
    began = time.perf_counter()
    with LocalPool(plan.job, workers) as pool:
        pool.start()
        up = time.perf_counter() - began
        for turn in range(rounds):
            loops = bare_everywhere(scenario, part, workers) if has_bare else None
            wall = swept(plan, pool, range(turn * part, (turn + 1) * part))
            if loops is not None:
                ratios.append(wall.wall / loops.wall)
                sums[0] += loops.wall
                used[0] += loops.used
            sums[1] += wall.wall
            used[1] += wall.used
    ratios.sort()
    print(f"{title}: {runs} runs, {workers} workers, up after {up:.2f} s")
    if ratios:
        print(f"  bare sum of loops / workers {sums[0]:.2f} s, sweep {sums[1]:.2f} s", end="; ")
        rates = [part * rounds / workers / seconds for seconds in sums]
        print(f"{rates[0]:.0f} and {rates[1]:.0f} runs a second and worker")
        print(f"  ratio {sums[1] / sums[0]:.2f} in all; of {rounds} rounds the median", end=" ")
        print(f"{ratios[len(ratios) // 2]:.2f}, the best {ratios[0]:.2f}")
        print(f"  processor time: loops {used[0]:.2f} s, sweep {used[1]:.2f} s,", end=" ")
        print(f"ratio {used[1] / used[0]:.2f};", end=" ")
        print("{:.0f} and {:.0f} runs a second of it".format(*(part * rounds / u for u in used)))
    else:
        print(f"  sweep {sums[1]:.2f} s, {1e3 * sums[1] * workers / runs:.2f} ms a run and worker")


def single(title: str, runs: int, rounds: int, **more: object) -> None:
    """Single-axis half seconds a second and processor, in this process alone."""
    plan = plan_for(AXIS, runs, check_every=0, **more)
    settle()
    loops, runner_cost, part = Cost(0, 0), Cost(0, 0), len(plan.points) // rounds
    with PointRunner(plan.job) as runner:
        tasks = [Task(n, point, str(n)) for n, point in enumerate(plan.points)]
        for task in tasks[:20]:
            runner.run(task)
        for turn in range(rounds):
            wall, used = time.perf_counter(), time.process_time()
            for task in tasks[turn * part : (turn + 1) * part]:
                runner.run(task)
            wall, used = time.perf_counter() - wall, time.process_time() - used
            runner_cost = Cost(runner_cost.wall + wall, runner_cost.used + used)
            one = bare(AXIS, part)
            loops = Cost(loops.wall + one.wall, loops.used + one.used)
    done = part * rounds
    print(f"{title}, in one process: {done / runner_cost.wall:.0f} runs a second", end=" ")
    print(f"({done / runner_cost.used:.0f} of processor time), bare", end=" ")
    print(f"loops {done / loops.wall:.0f} ({done / loops.used:.0f})")
    print(f"  ratio {runner_cost.wall / loops.wall:.2f}, of processor time", end=" ")
    print(f"{runner_cost.used / loops.used:.2f}")


def _first(plan: SweepPlan):
    from cosim.sweep.work.variants import Variants

    return Variants(plan.job).scenario(plan.points[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bare", nargs=2, metavar=("SCENARIO", "RUNS"))
    parser.add_argument("--runs", type=int, default=4000)
    parser.add_argument("--rounds", type=int, default=8)
    chosen = parser.parse_args()
    if chosen.bare:
        cost = bare(chosen.bare[0], int(chosen.bare[1]))
        print(cost.wall, cost.used)
        return
    workers = processors()
    compare("half a second of two_users_box", BOX, chosen.runs, workers, chosen.rounds)
    axis = "half a second of single_axis_distributed"
    compare(axis, AXIS, 2 * chosen.runs, workers, chosen.rounds)
    unchecked = {"check_every": 0}
    compare(f"{axis}, none checked", AXIS, 2 * chosen.runs, workers, chosen.rounds, **unchecked)
    compare(
        "the half second after 2 s, begun there",
        BOX,
        chosen.runs // 4,
        workers,
        1,
        start="2 s",
        sets=["duration=2.5 s", "expect=~", "channels.lan.loss=0.1"],
    )
    single(f"{axis} by seeds", chosen.runs // 2, chosen.rounds)
    grid = {"components.coupler_11.parameters.stiffness": "100..2000/40"}
    grid["components.object_1.parameters.mass"] = "0.1..1/50"
    single(f"{axis} by stiffness and mass", 0, chosen.rounds, seeds=None, vary=grid)


if __name__ == "__main__":
    main()
