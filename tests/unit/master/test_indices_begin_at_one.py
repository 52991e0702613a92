"""An element counted from 0 is refused with the index that it has here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of

COUNTED = {
    "connections": (["hand.force -> body.force[0]"], "write force[1]."),
    "record": (["body.force[0]"], "write force[1]."),
    "start": ({"force[3,0]": 1.0}, "write force[4,1]."),
}


@pytest.mark.parametrize("section", COUNTED)
def test_an_index_from_zero(tmp_path: Path, section: str) -> None:
    written, hint = COUNTED[section]
    body: dict[str, Any] = {"fmu": "object", "rate": 1024}
    scenario: dict[str, Any] = {
        "duration": 1,
        "components": {"hand": {"fmu": "hand", "rate": 1024}, "body": body},
    }
    (body if section == "start" else scenario)[section] = written
    with pytest.raises(InputError) as caught:
        assemble(scenario_of(tmp_path, scenario))
    assert str(caught.value).endswith(f"Indices begin at 1: {hint}")
