"""Whatever is done to a valid file, what comes out is a scenario or sentences with places."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError, InputErrors
from cosim.scenario import load
from cosim.scenario.resolved import to_yaml
from tests.support.scenario.scenario_documents import documents
from tests.support.scenario.small_scenario import SMALL

JUNK = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.sampled_from(["", "~", "1 s", "a.b -> c.d", "1e999 s", "1/0", "left", "..", "\x00", "é"])
    | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["include", "forward", "weights", "fmu", "device", "from", "by", "x"]),
            inner,
            max_size=3,
        )
    ),
    max_leaves=5,
)
SETTINGS = settings(
    deadline=None,
    max_examples=60,
    phases=[Phase.reuse, Phase.generate],  # shrinking a whole document takes minutes
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


def attempt(
    file: Path, text: str, sets: tuple[str, ...] = (), overlays: tuple[Path, ...] = ()
) -> None:
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        scenario = load(file, overlays, sets)
    except InputError as error:
        found = error.errors if isinstance(error, InputErrors) else [error]
        assert all(item.message.strip() for item in found)
        str(error).encode("utf-8")
    else:
        to_yaml(scenario)


def places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    keys: list[Any] = []
    if isinstance(node, dict):
        keys = list(node)
    elif isinstance(node, list):
        keys = list(range(len(node)))
    return [path, *(p for key in keys for p in places(node[key], (*path, key)))]


@SETTINGS
@given(st.data())
def test_a_node_replaced_by_anything(tmp_path: Path, data: st.DataObject) -> None:
    document = copy.deepcopy(data.draw(documents()))
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from([p for p in places(document) if p]))
        parent: Any = document
        for key in path[:-1]:
            parent = parent[key]
        action = data.draw(st.sampled_from(["replace", "delete", "rename", "add"]))
        if action == "replace" or isinstance(parent, list):
            parent[path[-1]] = data.draw(JUNK)
        elif action == "delete":
            del parent[path[-1]]
        elif action == "rename":
            parent[data.draw(st.text(max_size=4))] = parent.pop(path[-1])
        else:
            parent[data.draw(st.sampled_from(["include", "x", "rate", ""]))] = data.draw(JUNK)
    attempt(tmp_path / "s.yaml", json.dumps(document))


@SETTINGS
@given(st.data())
def test_characters_changed_anywhere(tmp_path: Path, data: st.DataObject) -> None:
    text = SMALL
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        length = data.draw(st.integers(0, 6))
        filler = data.draw(st.text("{}[]:,-> \n\t\"'&*!|#%@~0123abc.é\x00\u2028\ud800", max_size=4))
        text = text[:start] + filler + text[start + length :]
    attempt(tmp_path / "s.yaml", text)


@SETTINGS
@given(
    st.lists(
        st.one_of(
            st.text(max_size=20),
            st.builds(
                "{}={}".format,
                st.sampled_from(
                    [
                        "components.left",
                        "components.left.fmu",
                        "components",
                        "connections",
                        "connections.0",
                        "connections.0.from",
                        "channels.lan",
                        "channels.lan.loss",
                        "rates",
                        "record.0",
                        "expect",
                        "include",
                    ]
                ),
                JUNK.map(json.dumps) | st.text(max_size=10),
            ),
        ),
        min_size=1,
        max_size=3,
    )
)
def test_any_override(tmp_path: Path, sets: list[str]) -> None:
    attempt(tmp_path / "s.yaml", SMALL, tuple(sets))


@SETTINGS
@given(JUNK)
def test_any_overlay(tmp_path: Path, junk: Any) -> None:
    (tmp_path / "o.yaml").write_text(json.dumps(junk), "utf-8")
    attempt(tmp_path / "s.yaml", SMALL, overlays=(tmp_path / "o.yaml",))


@pytest.mark.parametrize("name", ["", "\x00", "~nobody/x", "a" * 5000, "scenarios/", "//", "."])
def test_any_name(name: str) -> None:
    with pytest.raises(InputError):
        load(name)
