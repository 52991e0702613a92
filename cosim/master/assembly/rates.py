"""Parameters that follow from the scenario's rates: they are set, and what contradicts is refused.

A component that wants to know its own period, or how many of them a network period has, says so
with the meaning of a parameter. With several channels the fastest that it sends through counts;
where a network period is no whole number of its own, the next lower number does, and a note says
so.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isclose

from cosim.base.component import Causality
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning
from cosim.master.components.participant import Participant
from cosim.scenario import Scenario


def follow_rates(
    scenario: Scenario, participants: Mapping[str, Participant], problems: Problems
) -> list[str]:
    """Give every participant the parameters that follow from the rates; returns notes."""
    notes: list[str] = []
    for name, participant in participants.items():
        own = Fraction(participant.period, participant.substeps)
        for variable in participant.interface.variables.values():
            if variable.meaning is None or variable.causality is not Causality.PARAMETER:
                continue
            match variable.meaning:
                case Meaning.SAMPLE_PERIOD:
                    value = float(own / scenario.base_rate)
                    why = f"{name} runs at {float(scenario.base_rate / own):g} Hz"
                case Meaning.NETWORK_TICKS:
                    network = _network_period(scenario, name)
                    if network is None:
                        continue
                    value = max(1, int(network / own))
                    rate = float(scenario.base_rate / network)
                    why = f"{name} sends at {rate:g} Hz and runs at "
                    why += f"{float(scenario.base_rate / own):g} Hz"
                    if network % own:
                        notes.append(
                            f"{why}: {float(network / own):g} of its periods to a packet, of which "
                            f"{name}.{variable.name} counts {value}"
                        )
                case _:
                    continue
            given = participant.parameters.get(variable.name)
            if given is None:
                participant.parameters[variable.name] = [value]
                continue
            with problems.at(("components", name, "parameters", variable.name)):
                if not isclose(float(given[0]), value, rel_tol=1e-9):
                    raise InputError(
                        f"{name}.{variable.name} is {given[0]:.10g}, but {why}, so it is "
                        f"{value:.10g}. Leave it out: it follows from the rates"
                    )
    return notes


def _network_period(scenario: Scenario, component: str) -> int | None:
    """Base ticks from packet to packet of the fastest channel that a component sends through."""
    periods = [
        connection.period or scenario.channels[connection.via].period
        for connection in scenario.connections
        if connection.source.component == component and connection.via is not None
    ]
    return min(periods, default=None)
