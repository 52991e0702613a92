"""Every archive runs in an importer that is not ours, and all flavours give the same bits."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy import simulate_fmu

from tests.support.fmus import fmu_support as support

TICKS = 16


def run(name: str, flavour: str) -> dict[str, np.ndarray]:
    """Outputs by their scalar names over some ticks."""
    step = support.step_of(name)
    result = simulate_fmu(
        str(support.path_of(name, flavour)),
        stop_time=TICKS * step,
        output_interval=step,
        step_size=step,
    )
    columns: dict[str, np.ndarray] = {}
    for column in result.dtype.names:
        values = result[column]
        if values.ndim == 1:
            columns[column] = values
        else:
            columns.update({f"{column}[{i + 1}]": values[:, i] for i in range(values.shape[1])})
    return columns


@pytest.mark.parametrize("name", [*support.MODELS, *support.PROBES])
def test_flavours_agree_bit_for_bit(name: str) -> None:
    fmi2, fmi3, arrays = (run(name, flavour) for flavour in ("fmi2", "fmi3", "fmi3-arrays"))
    outputs = [e.name for p in _outputs(name) for e in p]
    assert set(outputs) <= fmi2.keys() & fmi3.keys() & arrays.keys()
    for output in outputs:
        assert len(fmi3[output]) >= TICKS
        assert np.all(np.isfinite(fmi3[output]))
        assert fmi2[output].astype(float).tobytes() == fmi3[output].astype(float).tobytes()
        assert arrays[output].astype(float).tobytes() == fmi3[output].astype(float).tobytes()


def _outputs(name: str):
    from fmus.layout import SlotLayout, elements_of

    for placed in SlotLayout(support.source(name).model).placed:
        if placed.variable.causality == "output" and placed.variable.type != "string":
            yield elements_of(placed)
