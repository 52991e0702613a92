"""One of our FMUs, stepped by hand through FMPy: what emulators and ``mock`` move."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from typing import Any, cast


class SteppedModel:
    """An FMU by its bundled name; values are read and written by variable name, arrays whole.

    ``parameters`` are set before initialisation; an enumeration takes its number or its name.
    """

    def __init__(self, name: str, parameters: Mapping[str, Any]) -> None:
        import fmpy  # pyright: ignore[reportMissingTypeStubs]
        from fmpy.fmi3 import FMU3Slave  # pyright: ignore[reportMissingTypeStubs]

        import fmus

        path, reader = str(fmus.find(name)), cast("Any", fmpy)
        described: Any = reader.read_model_description(path)
        self._folder = str(reader.extract(path))
        self._references: dict[str, Any] = {v.name: v for v in described.modelVariables}
        self._fmu: Any = FMU3Slave(
            guid=described.guid,
            unzipDirectory=self._folder,
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self._fmu.instantiate()
        for key, value in parameters.items():
            self.set(key, value)
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()
        self._time = 0.0

    def set(self, name: str, value: Any) -> None:
        """Set a variable, or every element of an array."""
        if isinstance(value, Sequence) and not isinstance(value, str):
            for number, element in enumerate(value, start=1):  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
                self.set(f"{name}[{number}]", element)
            return
        variable = self._references[name]
        reference = [variable.valueReference]
        match variable.type:
            case "Float64":
                self._fmu.setFloat64(reference, [float(value)])
            case "Int32":
                self._fmu.setInt32(reference, [int(value)])
            case "Boolean":
                self._fmu.setBoolean(reference, [bool(value)])
            case "Enumeration":
                self._fmu.setInt64(reference, [self._number(variable, value)])
            case _:
                self._fmu.setString(reference, [str(value)])

    def pair(self, name: str) -> tuple[float, float]:
        """A variable of two elements."""
        references = [self._references[f"{name}[{i}]"].valueReference for i in (1, 2)]
        first, second = self._fmu.getFloat64(references)
        return float(first), float(second)

    def step(self, seconds: float) -> None:
        """One communication step."""
        self._fmu.doStep(self._time, seconds)
        self._time += seconds

    def close(self) -> None:
        """Free the instance and remove what was unpacked."""
        self._fmu.terminate()
        self._fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _number(self, variable: Any, value: Any) -> int:
        if not isinstance(value, str):
            return int(value)
        return next(int(item.value) for item in variable.declaredType.items if item.name == value)
