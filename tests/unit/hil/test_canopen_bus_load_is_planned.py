"""SYNC and 1, 2, 4 two-axis CANopen nodes take 24, 44, 83 % of a bus at 1024 Hz; 4 do not fit."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from hil.drivers.canopen.driver import CanopenDriver
from hil.setup.address import parse
from hil.setup.device_file import default
from hil.wire.can_load import bus_load

FINGERS = ("finger_a1", "finger_a2", "finger_b1", "finger_b2")


def use(nodes: str):
    return CanopenDriver.bus_use(parse(f"canopen+x://can0?nodes={nodes}"), default("canopen"))


@pytest.mark.parametrize(("count", "plain", "worst"), [(1, 24, 29), (2, 44, 53), (4, 83, 99.8)])
def test_published_loads(count, plain, worst):
    each = use("1")
    load = bus_load([*each.shared, *each.frames * count], 1024)
    assert 100 * load.plain == pytest.approx(plain, abs=0.5)
    assert 100 * load.worst == pytest.approx(worst, abs=0.5)


def test_more_nodes_for_the_same_joints_cost_more_of_the_bus():
    frames = [use(nodes).frames for nodes in ("1", "1,2,3", "1,2")]
    assert frames == [(8, 4), (4, 4, 4), (4, 4, 2, 2)]
    loads = [bus_load([0, *each], 1024).plain for each in frames]
    assert loads == sorted(loads)


def check(tmp_path, count: int) -> dict:
    lines = ["components:"]
    for number, finger in enumerate(FINGERS[:count], start=1):
        lines.append(f'  {finger}: {{device: "canopen+socketcan://can0?nodes={number}"}}')
        lines.append(f"  {finger.replace('finger', 'operator')}: ~")
    bench = tmp_path / "bench.yaml"
    bench.write_text("\n".join(lines) + "\n")
    done = CliRunner().invoke(
        cli,
        ["check", "two_users_box", "--with", str(bench), "--json"],
        catch_exceptions=False,
        standalone_mode=False,
    )
    return json.loads(done.stdout)


def test_a_scenario_on_one_bus_is_counted_with_one_sync_or_refused(tmp_path):
    (bus,) = check(tmp_path, 2)["buses"]
    assert (bus["frames_per_tick"], bus["devices"]) == (5, list(FINGERS[:2]))
    assert 100 * bus["load"] == pytest.approx(44, abs=0.5)
    with pytest.raises(InputError, match=r"82\.6%.*99\.8% with worst-case.*second bus"):
        check(tmp_path, 4)
