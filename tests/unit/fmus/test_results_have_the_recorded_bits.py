"""The single-axis models, signals and the user give recorded bits: on every platform, always."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from tests.support.fmus import fmu_support as support

# SHA-256 of all outputs over 300 steps; the first 16 digits.
GOLDEN = {
    "hand": "3e05773a61317d87",
    "object": "7b81ea5398e5a1e6",
    "operator": "f0d199da5f0849cd",
    "signal": "0e6c20680b340d33",
    "virtual_coupler": "033b4e1048da5431",
}

REAL = {"Real", "Float64"}
LEFT_AT_ZERO = {f"force[{number}]" for number in range(5, 18)}
"""Of the object: the bits were recorded when it took four forces."""
PARAMETERS = {
    "object": {"compensation": -1.5, "wall_stiffness": 3000.0, "wall_damping": 2.0},
    "operator": {"trajectory": 1, "sine_amplitude": [0.1, 0.05], "sine_frequency": [2.0, 3.0]},
    "signal": {"mode": 2, "amplitude": 1.5, "frequency": 3.0, "phase": 0.3},
    "virtual_coupler": {"computation_delay_ticks": 2},
}


def outputs(name: str, flavour: str) -> str:
    digest, state = hashlib.sha256(), 1
    with support.Fmu(name, flavour) as fmu:
        for parameter, value in PARAMETERS.get(name, {}).items():
            if isinstance(value, list) and flavour != "fmi3-arrays":
                for i, each in enumerate(value):
                    fmu.set(f"{parameter}[{i + 1}]", each)
            else:
                fmu.set(parameter, value)
        fmu.start()
        inputs = fmu.names("input")
        for _ in range(300):
            for variable in inputs:
                values = []
                size = fmu.shape(variable)
                for element in range(size):
                    name = f"{variable}[{element + 1}]" if size > 1 else variable
                    if name in LEFT_AT_ZERO:
                        values.append(0.0)
                        continue
                    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
                    drawn = np.ldexp(float(state >> 11), -53) - 0.5
                    values.append(drawn if fmu.kind(variable) in REAL else int(drawn > 0))
                fmu.set(variable, values if len(values) > 1 else values[0])
            digest.update(fmu.bits())
            fmu.step()
    return digest.hexdigest()[:16]


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
@pytest.mark.parametrize("name", GOLDEN)
def test_recorded_bits(name: str, flavour: str) -> None:
    assert outputs(name, flavour) == GOLDEN[name]
