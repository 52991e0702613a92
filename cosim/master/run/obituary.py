"""The sentence about a run whose process has ended before the run was over."""

from __future__ import annotations

import signal

from cosim.base.system.manner import manner
from cosim.master.run.whereabouts import Whereabouts
from cosim.scenario import Scenario

KEPT = "what was written before is kept"
COMPLETE = "the record is complete"
NOTHING = "nothing was recorded"


def obituary(
    status: int,
    whereabouts: Whereabouts,
    scenario: Scenario,
    left: str | None = None,
    *,
    burst: float | None = None,
) -> str:
    """Who ended the run's process, how, in what and when; without a full stop.

    ``status`` is the process's, negative after a signal; ``left`` what a Python component gave to
    ``sys.exit``, where one did; ``burst`` the time (s) after which the system kills a process that
    never sleeps, where it was asked to.
    """
    component, doing = whereabouts.sentence(scenario)
    if left is not None:
        return f"{component or 'the run'} left the process (SystemExit: {left}) {doing}"
    reason = whereabouts.log(component, scenario).reason()
    if -status == signal.SIGKILL:
        at = f"{component} was at work {doing}" if component else doing
        who = "from outside"
        if burst is not None:
            who += f", or by the system because it did not rest for {burst * 1e3:.0f} ms"
        return f"the run's process was killed (SIGKILL) {who}, while {at}"
    return f"{component or 'the run'} {manner(status)} {doing}{reason}"
