"""A paced run seen by Foxglove's protocol is the run that is recorded."""

from __future__ import annotations

from cosim.record.reader import open_run
from tests.browser.conftest import command
from tests.support.live.foxglove import FoxgloveViewer

ROWS, SCENES = 256, 6
FIELDS = {
    "vr_b.box_pose.x": "vr_b_box_pose_x",
    "vr_a.finger_1.force[2]": "vr_a_finger_1_force_2",
    "lan.forward.sequence": "lan_forward_sequence",
}


def test_rows_and_scene_of_a_paced_run_are_those_of_its_record(tmp_path):
    out = tmp_path / "run"
    words = ("two_users_box", "--realtime", "--foxglove", "--duration", "60")
    with command("run", *words, "--no-figure", "--no-report", "--out", str(out)) as (address, _):
        viewer = FoxgloveViewer(address)
        for topic in ("/scene", "/control"):
            viewer.subscribe(topic)
        rows, scenes = [], []
        while len(rows) < ROWS or len(scenes) < SCENES:
            match viewer.message():
                case ("/scene", at, message):
                    scenes.append((at, message))
                case (_, _, row):
                    rows.append(row)
        viewer.close()
    ticks = [int(row["tick"]) for row in rows]
    assert ticks == list(range(ticks[0], ticks[0] + len(ticks)))
    with open_run(out) as record:
        for name, field in FIELDS.items():
            assert [row[field] for row in rows] == record[name].values[ticks].tolist()
        for at, message in scenes:
            (box,) = [each for each in message["entities"] if each["id"] == "box vr_b"]
            place, tick = box["cubes"][0]["pose"]["position"], round(at * 1024 / 10**9)
            for axis in "xy":
                assert place[axis] == record[f"vr_b.box_pose.{axis}"].values[tick]
