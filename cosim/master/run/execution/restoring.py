"""Going on from a snapshot: its state put back, or the run repeated up to there."""

from __future__ import annotations

from cosim.base.errors import InputError, RunError
from cosim.base.recording import Forgetful
from cosim.master.run import checkpoint
from cosim.master.run.execution.kernel_run import KernelRun
from cosim.master.run.snapshot import Snapshot


def put_back(run: KernelRun, snapshot: Snapshot, *, end: int) -> None:
    """Have the state of a snapshot at once, in a run that goes to tick ``end``.

    Raises:
        InputError: it is beyond the end, or an FMU does not give its state away.
        RunError: a component does not take its state back.
    """
    stateless = checkpoint.without_state(run.assembly)
    if stateless:
        raise InputError(
            f"The FMU of {stateless[0]} does not give its state away, so that its run can only "
            "be repeated from tick 0: restore the snapshot before the run starts."
        )
    _refuse_beyond(snapshot, end)
    with run.fmus.guarded:
        checkpoint.put_back(snapshot, run.program, run.fmus.all, run.components)


def go_on(run: KernelRun, snapshot: Snapshot, *, end: int, recorded: bool) -> None:
    """Be where a snapshot was taken, before tick 0 of a run, be it by running again up to there.

    Raises:
        InputError: it is beyond the end.
        RunError: a component does not take its state back, or does not compute the same twice.
    """
    stateless = checkpoint.without_state(run.assembly)
    if not stateless:
        put_back(run, snapshot, end=end)
        return
    _refuse_beyond(snapshot, end)
    run.program.texts.record_into(None)
    run.run_to(snapshot.tick, Forgetful(run.groups) if recorded else None)
    if not checkpoint.same_state(snapshot, run.program):
        raise RunError(
            f"Run again from tick 0, because the FMU of {stateless[0]} does not give its "
            f"state away, the run has other values at tick {snapshot.tick} than the snapshot: "
            "one of its components does not compute the same twice."
        )


def _refuse_beyond(snapshot: Snapshot, end: int) -> None:
    if snapshot.tick > end:
        raise InputError(
            f"The snapshot is of tick {snapshot.tick}, but the run ends at tick {end}; "
            "give it a longer duration."
        )
