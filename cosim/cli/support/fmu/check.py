"""What ``cohaptic fmu validate`` finds: rules that are broken, and whether the FMU starts here."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cosim.base.errors import CohapticError, InputError


@dataclass(frozen=True, slots=True)
class StartVerdict:
    """Of one FMU."""

    breaks: tuple[str, ...]
    """Rules of the standard that its description breaks."""
    failure: str
    """Why it does not start on this machine; empty where it does."""

    @property
    def is_good(self) -> bool:
        """Whether nothing was found."""
        return not self.breaks and not self.failure


def judge(path: Path) -> StartVerdict:
    """Read it, load it, instantiate and initialise it in a process of its own, and free it.

    Raises:
        InputError: it cannot be read at all.
    """
    from cosim.cli.support.fmu.alone import scenario_of_fmu
    from cosim.master.fmu.reading import read_description
    from cosim.master.run.simulation import assemble
    from cosim.preparation.trial_start import try_to_start

    description = read_description(path.absolute())
    try:
        stop = repr(max(0.0, float(description.start_time or 0)) + 1)
        scenario = scenario_of_fmu(
            str(path), stop_time=stop, step_size=None, sets=("start_time=0",)
        )
        try_to_start(assemble(scenario))
    except InputError as error:
        return StartVerdict(description.breaks, error.message)
    except CohapticError as error:
        return StartVerdict(description.breaks, str(error))
    return StartVerdict(description.breaks, "")
