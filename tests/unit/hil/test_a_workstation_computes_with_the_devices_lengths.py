"""A workstation that computes with other links than the device has is refused: it would push askew.

A Haply's links on a workstation that thinks of a Quanser's gave 1.84 N where 1 N was asked for.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli

FITS = """\
components:
  finger_a1: {device: {url: "haply:///dev/ttyACM0", file: device.yaml}}
  operator_a1: ~
  vr_a: {parameters: {finger_1.device: haply, finger_1.max_force: 1.2}}
expect: ~
"""
HAPLY = "driver: haply\nestop: confirmed\n"


def check(folder: Path, overlay: str, file: str, scenario: str = "two_users_box") -> dict:
    (folder / "device.yaml").write_text(file)
    path = folder / "bench.yaml"
    path.write_text(overlay)
    arguments = ["check", scenario, "--with", str(path), "--json"]
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False, standalone_mode=False)
    return json.loads(done.stdout)


def test_the_same_links_are_taken(tmp_path: Path):
    assert check(tmp_path, FITS, HAPLY)["devices"]["finger_a1"]["file"]["preset"] == "haply"
    lengths = "proximal_length: 0.07, finger_1.distal_length: 0.09, finger_1.base_distance: 38 mm"
    assert check(tmp_path, FITS.replace("device: haply", lengths), HAPLY)


@pytest.mark.parametrize(
    ("old", "new", "file", "says"),
    [
        ("finger_1.device: haply, ", "", HAPLY, "proximal length 70 mm .* with 100 mm"),
        (
            "haply, ",
            "haply, finger_1.distal_length: 95 mm, ",
            HAPLY,
            "distal length 90 mm .* 95 mm",
        ),
        ("", "", HAPLY + "geometry: {base: 40 mm}\n", "base distance 40 mm .* with 38 mm"),
        ("", "", HAPLY + "geometry: {proximal: 71 mm}\n", "proximal length 71 mm .* with 70 mm"),
    ],
)
def test_other_links_are_refused_with_both_numbers(tmp_path: Path, old, new, file, says):
    with pytest.raises(InputError, match=says) as refused:
        check(tmp_path, FITS.replace(old, new, 1) if old else FITS, file)
    assert "finger_1.device or finger_1." in str(refused.value)
    assert refused.value.location.file.endswith("bench.yaml")


def test_a_workstation_behind_a_network_is_asked_as_well(tmp_path: Path):
    bench = FITS[: FITS.index("  vr_a")] + "expect: ~\n"
    with pytest.raises(InputError, match="proximal length 70 mm"):
        check(tmp_path, bench, HAPLY, "two_users_box_centralized")
