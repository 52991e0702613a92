"""Files that a scenario names: relative to where they are written, and absolute from then on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from cosim.base.meaning import Meaning
from cosim.master.components.participant import Participant
from cosim.master.components.python_component import file_source
from cosim.scenario import Kind, Scenario
from cosim.scenario.source.find import folder_at


def with_files(scenario: Scenario, participants: Mapping[str, Participant]) -> Scenario:
    """The scenario with absolute file names, which the participants get, too.

    A relative name starts from the folder of the file that it is written in, one of ``--set``
    from the working folder.
    """
    changed = dict(scenario.components)
    for name, participant in participants.items():
        variables = participant.interface.variables
        found: dict[str, str] = {}
        for parameter, given in changed[name].parameters.items():
            variable = variables.get(parameter)
            if variable is None or variable.meaning is not Meaning.FILE or not given:
                continue
            place = scenario.locate(("components", name, "parameters", parameter))
            file = (folder_at(place) / Path(str(given)).expanduser()).absolute()
            found[parameter] = str(file)
            participant.parameters[parameter] = [str(file)]
        if found:
            parameters = {**changed[name].parameters, **found}
            changed[name] = replace(changed[name], parameters=parameters)
        if changed[name].kind is Kind.PYTHON:
            source = file_source(changed[name].source, scenario.file.parent)
            changed[name] = replace(changed[name], source=source)
    if changed == scenario.components:
        return scenario
    return replace(scenario, components=changed)


def files_of(scenario: Scenario, participants: Mapping[str, Participant]) -> Iterator[Path]:
    """What else the numbers depend on: tables, devices' files, traces of channels."""
    for name, component in scenario.components.items():
        yield from files_read(participants[name])
        if component.kind is Kind.TABLE:
            yield Path(component.source)
        if component.kind is Kind.DEVICE and isinstance(component.options.get("file"), str):
            yield Path(component.options["file"])
    for channel in scenario.channels.values():
        for way in (channel.forward, channel.backward):
            files = (getattr(effect, "file", None) for effect in way.impairments.values())
            yield from (file for file in files if isinstance(file, Path))


def files_read(participant: Participant) -> list[Path]:
    """The files that its parameters name."""
    variables = participant.interface.variables
    return [
        Path(str(elements[0]))
        for name, elements in participant.parameters.items()
        if name in variables and variables[name].meaning is Meaning.FILE and elements[0]
    ]
