"""A misspelt key is answered with a key of the very form it stands in, and the forms are asked.

Nothing lists the forms: what is known at a place follows from the document's own type.
"""

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel, ValidationError

from cosim.base.document.problems import known_keys
from cosim.base.errors import InputError, InputErrors
from cosim.scenario import load
from cosim.scenario.form.document import document_form

CHANNEL: dict[str, Any] = {"between": ["a", "b"]}
WRITTEN: dict[str, dict[str, Any]] = {
    "the document": {},
    "a component": {"components": {"m": {"fmu": "hand"}}},
    "a channel": {"channels": {"lan": CHANNEL}},
    "delay by direction": {
        "channels": {"lan": {**CHANNEL, "delay": {"forward": 1, "backward": 1}}}
    },
    "loss in bursts": {
        "channels": {"lan": {**CHANNEL, "loss": {"good_to_bad": 0.1, "bad_to_good": 0.1}}}
    },
    "weighted jitter": {"channels": {"lan": {**CHANNEL, "jitter": {"weights": [1.0]}}}},
    "jitter by its spread": {"channels": {"lan": {**CHANNEL, "jitter": {"rms": "1 ms"}}}},
    "jitter one way": {"channels": {"lan": {**CHANNEL, "jitter": {"forward": {"rms": "1 ms"}}}}},
    "reorder": {"channels": {"lan": {**CHANNEL, "reorder": {"probability": 0.1}}}},
    "duplication one way": {
        "channels": {"lan": {**CHANNEL, "duplication": {"backward": {"probability": 0.1}}}}
    },
    "a connection in full": {"connections": [{"from": "a.x", "to": "b.x"}]},
    "a record with a rate": {"record": [{"signals": "a.*"}]},
}
BASE: dict[str, Any] = {"cohaptic": 1, "duration": 1, "components": {}}


def innermost(written: Any) -> dict[str, Any]:
    """The deepest mapping that a case writes: the form that it is about."""
    items = written.values() if isinstance(written, dict) else written
    deeper = [item for item in items if isinstance(item, dict | list)]
    for item in deeper:
        if isinstance(item, dict) or (item and isinstance(item[0], dict)):
            return innermost(item)
    return written


@pytest.mark.parametrize("case", WRITTEN)
def test_what_may_be_written_there_is_what_is_known_there(case: str):
    written = {**BASE, **deepcopy(WRITTEN[case])}
    form = innermost({key: written[key] for key in WRITTEN[case]}) if WRITTEN[case] else written
    form["no_such_key"] = 1
    with pytest.raises(ValidationError) as caught:
        document_form().model_validate(written)
    (finding,) = (e for e in caught.value.errors() if e["type"] == "extra_forbidden")
    known = known_keys(document_form(), finding["loc"])
    form.pop("no_such_key")
    assert set(form) <= set(known)
    for key in set(known) - set(form) - {"include"}:
        form[key] = object()
        with pytest.raises(ValidationError) as caught:
            document_form().model_validate(written)
        assert all(e["type"] != "extra_forbidden" for e in caught.value.errors()), key
        form.pop(key)


@pytest.mark.parametrize("case", WRITTEN)
def test_it_is_refused_where_it_stands(case: str, tmp_path: Path):
    """Also where a union's tag has the name of a key, which once ended in a traceback."""
    written = {**BASE, **deepcopy(WRITTEN[case])}
    form = innermost({key: written[key] for key in WRITTEN[case]}) if WRITTEN[case] else written
    form["no_such_key"] = 1
    file = tmp_path / "case.yaml"
    file.write_text(json.dumps(written, indent=1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load(file)
    found = caught.value.errors if isinstance(caught.value, InputErrors) else [caught.value]
    (told,) = (error for error in found if "unknown key 'no_such_key'" in error.message)
    lines = file.read_text(encoding="utf-8").splitlines()
    assert str(told).startswith(f"{file}:")
    assert "no_such_key" in lines[int(str(told).removeprefix(f"{file}:").split(":")[0]) - 1]


def test_a_document_of_another_kind_is_asked_as_well():
    class Inner(BaseModel):
        depth: int

    class Outer(BaseModel):
        inner: list[Inner] | None = None

    assert known_keys(Outer, ("x",)) == ["inner"]
    assert known_keys(Outer, ("inner", 3, "x")) == ["depth"]
    assert known_keys(Outer, ("inner", 3, "depth", "x")) == []
