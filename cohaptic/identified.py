"""What a device is, from its runs: ``cohaptic.identify``."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from cohaptic.described import described
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.identification.records import component_of, payload_of, recording
from cosim.identification.results import Identified
from cosim.identification.results import identify as identify_recordings
from cosim.identification.samples import Described, Recording
from cosim.reading import load
from cosim.record import open_run

HEAVIEST = 1.0
"""kg on the tip: more is no desktop device's."""


def identify(
    *runs: str | Path,
    payloads: Mapping[str, float] | None = None,
    component: str | None = None,
    device: str | Path | None = None,
    force: str | None = None,
    alike: bool = True,
) -> Identified:
    """Inertia, friction, latency, offset and gain of a device, each with its interval.

    Args:
        runs: folders of its runs, such as those of the excitation that ``cohaptic identify --plan``
            writes.
        payloads: mass on the tip (kg) by run, of runs that are not a plan's.
        component: which device, where a run has several.
        device: its device file, where that of the run has moved.
        force: recorded force of a sensor on the tip, such as ``force_a1.force``.
        alike: whether both sides have the same inertia.

    Returns:
        ``found["latency"].value``, ``.low`` and ``.high``; a value is ``None`` where ``reason``
        says why the runs do not tell it.

    Raises:
        InputError: a run cannot be used, or they are of different devices.
    """
    folders = [Path(each) for each in runs]
    if not folders:
        raise InputError("name one or several run folders.")
    if len({each.resolve() for each in folders}) < len(folders):
        raise InputError("a run is named twice: each of them counts once.")
    loads = _loads(payloads or {}, folders)
    recordings: list[Recording] = []
    steps: list[int] = []
    known: Described | None = None
    with ExitStack() as stack:
        for folder in folders:
            run = stack.enter_context(open_run(folder))
            name = component_of(run, component)
            scenario = load(run.scenario_file)
            this = described(scenario, name, None if device is None else Path(device))
            if known is not None and this.bar != known.bar:
                raise InputError(f"{folder} is of a device of another size than {folders[0]}.")
            known = known or this
            payload = loads.get(folder)
            rows, step = recording(
                run,
                scenario,
                name,
                limit=this.limit,
                payload=payload_of(scenario, name) if payload is None else payload,
                force=force,
            )
            recordings.append(rows)
            steps.append(step)
    assert known is not None, "there is a run"
    return identify_recordings(known, recordings, steps, alike=alike)


def _loads(payloads: Mapping[str, float], folders: list[Path]) -> dict[Path, float]:
    """The mass (kg) on the tip of each run that was said, by its path or its name alone."""
    found: dict[Path, float] = {}
    for name, mass in payloads.items():
        matches = [each for each in folders if str(each) == name or each.name == name]
        if not matches:
            hint = did_you_mean(name, [str(each) for each in folders])
            raise InputError(f"a payload is said of '{name}', which is none of the runs.{hint}")
        if len(matches) > 1:
            raise InputError(
                f"a payload is said of '{name}': {len(matches)} runs have that name; say the path."
            )
        if matches[0] in found:
            raise InputError(f"the payload of {matches[0]} was said before.")
        if not 0.0 <= mass <= HEAVIEST:
            raise InputError(
                f"a payload of {mass:g} kg is said of '{name}': from 0 to {HEAVIEST:g} kg go on a "
                "tip."
            )
        found[matches[0]] = mass
    return found
