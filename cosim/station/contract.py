"""What two stations of a scenario must agree on, as plain values for the contract's hash."""

from __future__ import annotations

from typing import Any

from cosim.base.meaning import OF_OWN_DEVICE
from cosim.master.assembly.assemble import Assembly
from cosim.station.half import Half, Peer


def contract_of(assembly: Assembly, half: Half, peer: Peer) -> dict[str, Any]:
    """The contract between ``half`` and ``peer``.

    It holds rates, the layout of what crosses, parameters of the components at both ends of the
    channels (environment and couplers) and the hashes of their FMUs. Device kind, calibration,
    paths and what is recorded are left out.
    """
    scenario = assembly.scenario
    ends: set[str] = set()
    for bundle in (*peer.sends, *peer.receives):
        ends |= {field.name.partition(".")[0] for field in bundle.fields}
    channels = {bundle.channel: bundle for bundle in (*peer.sends, *peer.receives)}
    return {
        "base_rate": str(scenario.base_rate),
        "start_time": str(scenario.start_time),
        "rates": {name: str(bundle.period) for name, bundle in channels.items()},
        "packets": {
            f"{bundle.source} to {bundle.target} ({bundle.channel})": bundle.describe()
            for bundle in (*peer.sends, *peer.receives)
        },
        "clock": peer.clock,
        **_transforms(assembly, half, peer),
        "components": {name: _component(assembly, name) for name in sorted(ends)},
        "stations": sorted((half.own, peer.name)),
    }


def _transforms(assembly: Assembly, half: Half, peer: Peer) -> dict[str, Any]:
    """What connections between the two stations make of values, where they do anything."""
    scenario = assembly.scenario
    ends = {half.own, peer.name}
    found = {
        str(each): {
            "factor": each.factor,
            "offset": each.offset,
            "unit": "ignored" if each.ignores_unit else "converted",
        }
        for each in scenario.connections
        if each.via is not None and set(scenario.channels[each.via].between) == ends
        if each.ignores_unit or (each.factor, each.offset) != (1.0, 0.0)
    }
    return {"connections": found} if found else {}


def _component(assembly: Assembly, name: str) -> dict[str, Any]:
    participant = assembly.participants[name]
    declared = participant.interface.variables
    parameters = {
        name: values
        for name, values in participant.parameters.items()
        if name not in declared or declared[name].meaning_of() not in OF_OWN_DEVICE
    }
    found: dict[str, Any] = {"period": participant.period, "parameters": parameters}
    if participant.fmu is not None:
        found["sha256"] = participant.fmu.sha256
    else:
        # Where a Python file lies is a station's own affair.
        found["source"] = assembly.scenario.components[name].source.rpartition("/")[2]
    return found
