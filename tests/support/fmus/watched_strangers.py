"""What of our C no bundled scenario reaches: FMUs of others, event mode, isolation, restarts, logs.

``python -m tests.support.fmus.watched_strangers FOLDER`` runs it all with the kernel in FOLDER,
which ``watched.build_kernel`` has made, in this process and in those of isolated FMUs. It says what
it has done, a word a line.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np

from cosim.base.errors import CohapticError
from cosim.base.recording import MemorySink
from cosim.master.kernel import build as kernel_build
from cosim.master.run.simulation import assemble
from cosim.scenario import Scenario, load
from tests.support.fmus.clocked import INTERFACE, clocked_fmu
from tests.support.fmus.failing import failing
from tests.support.fmus.foreign import foreign_fmu, scalar
from tests.support.fmus.mortal import scenario
from tests.support.fmus.watched import KERNEL

ERRATIC = (Path(__file__).parent / "native" / "erratic.h").read_text()
SEEDS = 60
CUSTOMIZE = """
import os
from pathlib import Path
from cosim.master.kernel import build
build.find_kernel = lambda: Path(os.environ["WATCHED_KERNEL"])

def leave(status, plain=os._exit):
    from tests.support.fmus.watched_strangers import say_what_was_reached
    say_what_was_reached()
    plain(status)

os._exit = leave
"""
"""``sitecustomize``: the processes of isolated FMUs take the kernel that is watched, too."""
REACHED = """
void __gcov_dump(void);
void say_what_was_reached(void) { __gcov_dump(); }
"""
"""For a kernel that counts its lines, which it tells when a process ends as others do."""
SAYS = r"""
    static int hook(Foreign *m, const char *call)
    {
        if (is(call, "DoStep")) {
            void *to = m->environment;
            m->log2(to, 0, 1, 0, "%.*s %5d %-4u|%x %o %ld", 2, "abc", -7, 8u, 255, 8, 9L);
            m->log2(to, 0, 1, 0, "%g %e %f %Lf %c %% %p %n", 1e300, -1e-9, 0.5, 2.5L, 'x',
                    (void *)8, (int *)0);
            m->log2((void *)8, 0, 3, 0, "%s", (const char *)0);
            for (int i = 0; i < 400; i++)
                say(m, i % 4, "a word that is long enough to fill what there is of room");
        }
        return 0;
    }
    #define HOOK hook
"""


def run(written: Scenario, ticks: int | None = None) -> None:
    """To its end or its error; another run, and one from the middle of the first."""

    def again() -> None:
        simulation.restore(simulation.snapshot())

    with assemble(written) as simulation:
        middle = (written.ticks if ticks is None else ticks) // 2
        simulation.run(MemorySink(), until=ticks, pauses={middle: again}, keep_fmus=True)
        simulation.renew(simulation.assembly)
        simulation.run(MemorySink(), until=ticks, keep_fmus=True)


def of_text(folder: Path, text: str) -> Scenario:
    """A scenario of a folder of its own."""
    file = folder / "test.yaml"
    file.write_text(text)
    return load(file)


def clocked(folder: Path, keys: str = "") -> None:
    """Every kind of clock."""
    fmu = clocked_fmu(folder)
    run(
        of_text(
            folder,
            "cohaptic: 1\nduration: 0.6\nbase_rate: 100\ncomponents:\n"
            f"  a: {{fmu: {fmu}, rate: 100, start: {{u: 0.7}}{keys}}}\n"
            f"  b: {{fmu: {fmu}, rate: 100{keys}}}\n"
            "connections: [a.told -> b.triggered, a.n -> b.d]\n"
            "events: [{at: 0.3, set: {a.p: 5}}]\n",
        )
    )


def typed(folder: Path, *, is_bare: bool, is_isolated: bool) -> None:
    """Values of every type."""
    for version in (2, 3):
        with failing("nothing", 0, "", Path(os.devnull)):
            run(of_text(folder, scenario(version, is_bare=is_bare, is_isolated=is_isolated)))


@cache
def erratic_scenario(folder: Path, keys: str) -> Scenario:
    """One with an FMU that answers anything; made and read once for all of them."""
    folder.mkdir()
    kinds = ("constant", "fixed", "tunable", "changing", "countdown", "triggered")
    clocks = "".join(
        f'<Clock name="{kind}" valueReference="{number}" causality="input" '
        f'intervalVariability="{kind}"'
        f"{' intervalDecimal=' + chr(34) + '0.02' + chr(34) if kind == 'constant' else ''}/>"
        for number, kind in enumerate(kinds, 10)
    )
    variables = (
        scalar(3, "u", 1, causality="input", start="0")
        + scalar(3, "d", 2, "Int32", causality="input", start="0")
        + scalar(3, "y", 3, causality="output")
        + scalar(3, "n", 4, "Int32", causality="output", clocks="10")
        + clocks
        + '<Clock name="told" valueReference="16" causality="output" '
        'intervalVariability="triggered"/>'
    )
    fmu = foreign_fmu(
        folder,
        3,
        variables,
        snippet=ERRATIC,
        structure="".join(f'<Output valueReference="{each}"/>' for each in (3, 4, 16)),
        interface={key: INTERFACE[key] for key in ("hasEventMode", "mightReturnEarlyFromDoStep")},
    )
    text = (
        "cohaptic: 1\nduration: 0.4\nbase_rate: 100\ncomponents:\n"
        f"  it: {{fmu: {fmu}, rate: 100, feedthrough: true{keys}}}\n"
        f"  signal: {{fmu: signal, rate: 100}}\nconnections: [it.told -> it.triggered]\n"
    )
    return of_text(folder, text)


def erratic(folder: Path, seed: int, keys: str = "") -> None:
    """Whatever it does is a sentence, or nothing."""
    os.environ["ERRATIC"] = str(seed)
    kept = folder.parent / ("erratic-apart-kept" if keys else "erratic-kept")
    try:
        with assemble(erratic_scenario(kept, keys)) as simulation:
            simulation.run(MemorySink())
    except CohapticError as error:
        assert "it" in str(error), error  # noqa: PT017 - any sentence will do, and none is good too


def speaking(folder: Path) -> None:
    """All that a message can be made of."""
    variables = scalar(2, "u", 1, causality="input", start="0")
    fmu = foreign_fmu(folder, 2, variables, snippet=SAYS)
    text = "cohaptic: 1\nduration: 0.08\nbase_rate: 100\n"
    text = f"{text}components: {{it: {{fmu: {fmu}, rate: 100}}}}\n"
    with assemble(of_text(folder, text)) as simulation:
        simulation.run(MemorySink())


def tasks() -> Iterator[tuple[str, Callable[[Path], None]]]:
    """By name."""
    apart = ", isolate: process"
    yield "clocked", clocked
    yield "clocked-apart", lambda folder: clocked(folder, apart)
    for is_bare in (False, True):
        for is_isolated in (False, True):
            yield (
                f"typed-{is_bare}-{is_isolated}",
                lambda folder, bare=is_bare, away=is_isolated: typed(
                    folder, is_bare=bare, is_isolated=away
                ),
            )
    yield "speaking", speaking
    yield "rounding", rounding
    yield "arrays", arrays
    yield "erratic-apart", lambda folder: erratic(folder, 3, apart)
    for seed in range(SEEDS):
        yield f"erratic-{seed}", lambda folder, seed=seed: erratic(folder, seed)


def restarts() -> None:
    """Ours, begun anew without being loaded, with packets under way and channels turned."""
    from cosim.analysis import load_tuned
    from cosim.reading import FORMS

    turned = "events=[{at: 40 ticks, set: {lan.round_trip_delay: 4, vr_a.coupling_stiffness: 40}}]"
    run(load_tuned("two_users_box", (), (turned,), forms=FORMS), 160)
    older = ("components.finger_a1.flavour=fmi2", "components.vr_b.flavour=fmi2")
    run(load_tuned("two_users_box", (), older, forms=FORMS), 64)


def rounding(folder: Path) -> None:
    """One that changes how the processor computes."""
    snippet = """
        static int hook(Foreign *m, const char *call)
        {
        #if defined(__x86_64__)
            unsigned mode = 0x1f80 | 0x8040 | 0x2000;
            __asm__ volatile("ldmxcsr %0" : : "m"(mode));
        #endif
            return 0;
        }
        #define HOOK hook
    """
    variables = scalar(3, "u", 1, causality="input", start="0")
    fmu = foreign_fmu(folder, 3, variables, snippet=snippet)
    text = "cohaptic: 1\nduration: 0.08\nbase_rate: 100\n"
    text = f"{text}components: {{it: {{fmu: {fmu}, rate: 100}}}}\n"
    with assemble(of_text(folder, text)) as simulation:
        simulation.run(MemorySink())


def arrays(_: Path) -> None:
    """What Python has the kernel do with arrays, beside a run: sums, and values of a link."""
    from cosim.link.stream.bundle import Field, PacketBundle
    from cosim.master.kernel.native import library
    from cosim.station.admission import CompiledAdmission
    from tests.support.link.support import PERIOD, TICK

    random = np.random.default_rng(1)
    words = random.integers(-(2**62), 2**62, 64)
    library().kernel_checksum(words.ctypes.data, words.size)
    fields = (
        Field(name="position", minimum=-1.0, maximum=1.0, speed=3.0),
        Field(name="count", integer=True),
        Field(name="pair", size=2, minimum=-10.0, maximum=10.0, speed=100.0),
    )
    bundle = PacketBundle(source="a", target="b", fields=fields, period=PERIOD, tick=TICK)
    judge, out = CompiledAdmission(bundle), np.zeros(bundle.size)
    for ticks in range(64):
        values = np.zeros(bundle.size)
        values[ticks % bundle.size] = random.choice([0.5, 1.0, -2.0, 1e300, np.nan, 2.0**53 + 2])
        judge.judge(values, ticks, out, newest=ticks % 3 > 0)


def say_what_was_reached() -> None:
    """Have a kernel that counts its lines write how often each was run."""
    from cosim.master.kernel.native import library

    say = getattr(library(), "say_what_was_reached", None)
    if say is not None:
        say()


def main() -> None:
    """All of it; ``os._exit``, because Python leaves things behind at its own end."""
    folder = Path(sys.argv[1])
    kernel_build.find_kernel = lambda: folder / KERNEL
    (folder / "sitecustomize.py").write_text(CUSTOMIZE)
    os.environ |= {
        "PYTHONPATH": f"{folder}{os.pathsep}{Path.cwd()}",
        "WATCHED_KERNEL": str(folder / KERNEL),
    }
    for name, task in tasks():
        own = folder / name
        own.mkdir(exist_ok=True)
        task(own)
        print(name, flush=True)
    restarts()
    print("restarts", flush=True)
    say_what_was_reached()
    os._exit(0)


if __name__ == "__main__":
    main()
