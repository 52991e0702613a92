"""The Foxglove protocol beside the page: who is let in, what is offered, and when it goes."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from websockets.exceptions import InvalidStatus

from tests.support.live.client import served
from tests.support.live.foxglove import NEW, OLD, FoxgloveViewer


@pytest.fixture(scope="module")
def server():
    with served("nothing", foxglove=True) as page:
        yield f"ws://{page.netloc}/foxglove/{page.fragment}"


def refusal(address: str, *protocols: str, **more) -> int:
    with pytest.raises(InvalidStatus) as refused:
        FoxgloveViewer(address, *protocols, **more)
    return refused.value.response.status_code


@pytest.mark.parametrize(("asked", "chosen"), [((NEW, OLD), NEW), ((OLD,), OLD)])
def test_both_names_of_the_protocol_are_spoken(server, asked, chosen):
    viewer = FoxgloveViewer(server, *asked, origin="https://viewer.example")
    assert viewer.protocol == chosen
    assert viewer.info["capabilities"] == ["time"]
    viewer.close()


def test_who_has_not_the_token_or_the_name_or_the_protocol_is_refused(server):
    assert refusal(server[:-1]) == 403
    assert refusal(server.rpartition("/")[0] + "/") == 403
    assert refusal(server, additional_headers={"Host": "evil.example"}) in {400, 403}
    assert refusal(server, "cohaptic") == 400


def test_a_server_that_was_not_asked_for_it_does_not_speak_it():
    with served("nothing") as page:
        address = f"ws://{page.netloc}/foxglove/{page.fragment}"
        assert refusal(address) == 404


@pytest.mark.parametrize(
    "said",
    [
        *("{", "[]", '{"op":"subscribe"}', '{"op":"subscribe","subscriptions":[1]}'),
        *('{"op":"unsubscribe","subscriptionIds":["a"]}', '{"op":"setParameters"}'),
    ],
)
def test_nonsense_is_dropped(server, said):
    viewer = FoxgloveViewer(server)
    viewer.socket.send(said)
    viewer.socket.send(
        json.dumps({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99999}]})
    )
    while "There is no channel 99999." not in viewer.statuses:
        viewer._next()
    assert "No run goes on; the next one is shown." in viewer.statuses
    viewer.close()


def test_rows_come_whole_once_and_in_order_and_the_channel_goes_with_the_run(server):
    from cosim.realtime.live import Feed
    from cosim.realtime.ring import Ring

    viewer = FoxgloveViewer(server)
    ring = Ring.create(2, capacity=256)
    feed = Feed("nothing", 1000.0, {}, [ring], start=5.0)
    columns = [
        SimpleNamespace(name="a.x[1]", unit="m", is_float=True),
        SimpleNamespace(name="a.count", unit=None, is_float=False),
    ]
    try:
        feed.publish([SimpleNamespace(name="control", period=2, columns=columns)])
        viewer.subscribe("/control")
        while viewer.clock is None:
            viewer._next()
        rows = np.empty((100, 2), np.int64)
        rows[:, 0] = np.linspace(0.0, 1.0, 100).view(np.int64)
        rows[:, 1] = -(2**60) - np.arange(100)
        ring.extend(rows)
        found = []
        while len(found) < 100:
            if (said := viewer.message()) is not None:
                found.append(said)
        assert [row["a_count"] for _, _, row in found] == rows[:, 1].tolist()
        assert [row["a_x_1"] for _, _, row in found] == np.linspace(0.0, 1.0, 100).tolist()
        assert [row["tick"] for _, _, row in found] == list(range(0, 200, 2))
        assert [at for _, at, _ in found] == [5 * 10**9 + tick * 10**6 for tick in range(0, 200, 2)]
    finally:
        feed.remove()
    while viewer.channels:
        viewer._next()
    ring.remove()
    viewer.close()


def test_the_scene_of_the_page_is_the_scene_of_foxglove_and_what_is_gone_is_deleted():
    from cosim.base.foxglove.entities import SceneUpdates
    from cosim.base.foxglove.schema import scene_schema

    box = {"name": "vr", "station": "a", "pose": ["x", "y", "o"], "side": 0.1}
    fingers = [
        {"name": f"w{world} 1", "station": "a", "position": ["x", "y"], "force": ["f", "g"]}
        | {"share": "s", "world": world}
        for world in (0, 1)
    ]
    updates = SceneUpdates(
        {"boxes": [box], "fingers": fingers, "bodies": [], "walls": [[0, 0, 1, 0]]}
    )
    at = {"x": 0.1, "y": 0.2, "o": 0.0, "f": 1.0, "g": 0.0, "s": 0.2}
    seen = [updates.message(at | {"s": share}, 10**9) for share in (0.2, 0.8)]
    names = [{entity["id"] for entity in message["entities"]} for message in seen]
    assert names == [{"box vr", f"finger w{world} 1", "wall 1"} for world in (0, 1)]
    gone = {"timestamp": {"sec": 1, "nsec": 0}, "type": 0, "id": "finger w0 1"}
    assert [message["deletions"] for message in seen] == [[], [gone]]
    for message in seen:
        conforms(json.loads(scene_schema()), message)


def conforms(schema: dict, value) -> None:
    """What is sent has the types that its schema says, and nothing that it does not."""
    if schema["type"] == "array":
        for each in value:
            conforms(schema["items"], each)
    elif schema["type"] == "object":
        assert value.keys() == schema["properties"].keys()
        for key, entry in schema["properties"].items():
            conforms(entry, value[key])
    else:
        kinds = {"boolean": bool, "string": str, "number": (int, float), "integer": int}
        assert isinstance(value, kinds[schema["type"]])
