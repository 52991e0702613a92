"""``cohaptic theory``: the command forms and JSON keys that scripts rely on, and its sentences."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli


def run(*arguments: str) -> str:
    result = CliRunner().invoke(cli, ["theory", *arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def answer(*arguments: str) -> dict[str, Any]:
    return json.loads(run(*arguments, "--json"))


def refusal(*arguments: str) -> str:
    with pytest.raises(InputError) as caught:
        CliRunner().invoke(
            cli, ["theory", *arguments], catch_exceptions=False, standalone_mode=False
        )
    return str(caught.value)


def test_radius() -> None:
    loop = ("--architecture", "centralized", "--set", "k_1=800", "--set", "k_2=800")
    found = answer("radius", *loop, "--set", "b=3", "--round-trip-delay", "1", "--ratio", "8")
    assert f"{found['spectral_radius']:.5f}" == "1.19967"
    assert found["stable"] is False
    assert "unstable" in run("radius", *loop, "--set", "b=3", "--round-trip-delay", "1")


def test_the_three_delay_forms_have_the_same_poles() -> None:
    def radius(*delay: str) -> float:
        return answer("radius", "--architecture", "distributed", *delay)["spectral_radius"]

    one_each = radius("--each-way-delay", "1")
    assert one_each == pytest.approx(radius("--round-trip-delay", "2"), rel=1e-10)
    assert one_each == pytest.approx(
        radius("--forward-delay", "2", "--backward-delay", "0"), rel=1e-10
    )
    assert one_each != pytest.approx(radius("--round-trip-delay", "1"), rel=1e-6)


def test_boundary() -> None:
    loop = ("--architecture", "single", "--set", "b=10", "--vary", "k", "--range", "1:50000")
    ((low, high),) = answer("boundary", *loop)["stable"]
    assert low == 1
    assert high == pytest.approx(20480, abs=1e-6)
    assert "20480" in run("boundary", *loop)


def test_damping() -> None:
    found = answer("damping", "--architecture", "distributed", "--model", "original")
    assert f"{found['damping']:.4g}" == "2.039"
    assert f"{found['compensation']:.4g}" == "-1.509"
    assert found["compensated_stable"]
    simplified = answer("damping", "--architecture", "distributed", "--model", "simplified")
    assert f"{simplified['damping']:.4g}" == "1.067"
    remote = answer("damping", "--architecture", "centralized", "--ratio", "2")
    assert f"{remote['damping']:.5g}" == "0.041656"


def test_damping_with_every_hand_on_the_box() -> None:
    gains = ("k_11=800", "b_11=3", "k_12=170", "b_12=3", "k_o=77.5", "b_o=10")
    settings = [part for gain in gains for part in ("--set", gain)]
    found = answer("damping", "--architecture", "distributed", *settings, "--all-hands")
    assert f"{found['compensation']:.3f}" == "-0.877"


def test_stiffness() -> None:
    assert f"{answer('stiffness', '--architecture', 'distributed')['stiffness']:.2f}" == "2729.35"
    found = answer("stiffness", "--architecture", "centralized")
    assert f"{found['stiffness']:.2f} {found['local']:.2f}" == "84.76 967.74"


def test_naming_one_of_a_pair_sets_both_and_b_sets_every_coupler() -> None:
    def parameters(*settings: str) -> dict[str, float]:
        texts = [part for setting in settings for part in ("--set", setting)]
        return answer("radius", "--architecture", "distributed", *texts)["parameters"]

    assert parameters("k_21=70")["k_12"] == 70
    both = parameters("k_21=70", "k_12=90")
    assert (both["k_12"], both["k_21"]) == (90, 70)
    damped = parameters("b=7", "b_22=5")
    assert {damped[name] for name in ("b_12", "b_21", "b_o1", "b_o2")} == {7}
    assert (damped["b_11"], damped["b_22"]) == (5, 5)
    assert damped["b_c1"] == 0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--set", "m_h=-1"), "m_h is -1 kg: a mass must be positive."),
        (("--set", "m_o=0"), "a mass must be positive"),
        (("--set", "k_11=-5"), "cannot be negative"),
        (("--set", "k_11=inf"), "finite"),
        (("--ratio", "0"), "--ratio 0: it must be positive."),
        (("--ratio", "1/0"), "give a positive number"),
        (("--control-rate", "fast"), "give a positive number"),
        (("--set", "k_11q=3"), "Did you mean k_11?"),
        (("--set", "k_11"), "write NAME=VALUE"),
        (("--set", "k_11=stiff"), "not a number"),
        (("--round-trip-delay", "-1"), "cannot be negative"),
        (("--round-trip-delay", "1", "--forward-delay", "1"), "one form only"),
        (("--users", "1"), "2 to 9 users"),
        (("--computation-delay", "-1"), "cannot be negative"),
    ],
)
def test_nonsense_gets_a_sentence(arguments: tuple[str, ...], sentence: str) -> None:
    assert sentence in refusal("radius", "--architecture", "distributed", *arguments)


def test_the_architecture_has_to_be_said() -> None:
    assert "--architecture" in refusal("radius")


def test_a_range_has_two_ends_in_order() -> None:
    loop = ("boundary", "--architecture", "distributed", "--vary", "k_12")
    assert "LOW:HIGH" in refusal(*loop, "--range", "5")
    assert "empty" in refusal(*loop, "--range", "5:1")
    assert "Did you mean" in refusal(*loop[:3], "--vary", "k_1q", "--range", "1:5")


def test_map(tmp_path: Path) -> None:
    plane = ("--vary", "k_11", "--range", "100:20000", "--vary", "k_12", "--range", "50:4000")
    loop = ("map", "--architecture", "distributed", *plane, "--points", "5")
    out = tmp_path / "map.png"
    found = answer(*loop, "--round-trip-delay", "1", "--out", str(out))
    assert np.array(found["stable"]).shape == (5, 5)
    assert 0 < found["stable_share"] < 1
    assert out.read_bytes().startswith(b"\x89PNG")
    assert "two different parameters" in refusal(*loop[:5])
    spoken = CliRunner().invoke(cli, ["theory", *loop, "--out", str(tmp_path / "map.wav")])
    assert spoken.exit_code == 2
    assert "has to end in .png, .svg, .pdf" in spoken.stderr


@pytest.mark.parametrize("number", ["5.1", "6.5"])
def test_figure(number: str, tmp_path: Path) -> None:
    out = tmp_path / "figure.svg"
    found = answer("figure", number, "--out", str(out), "--points", "12")
    assert found["figure"] == number
    assert "<svg" in out.read_text(encoding="utf-8")


def test_figures_and_tables_that_are_not_there() -> None:
    assert "5.1" in refusal("figure", "5.11", "--out", "x.png")
    assert "no table" in refusal("table", "7.1")


def test_table() -> None:
    rows = answer("table", "6.2")["rows"]
    assert [f"{row['damping']:.4g}" for row in rows] == ["0.2937", "0", "2.039", "1.067"]
    assert [row["thesis"] for row in rows] == ["0.04", "0", "2.1", "1.4"]
    assert any(row["parameter"] == "k_o" for row in answer("table", "6.1")["rows"])
    assert "thesis 0.04" in run("table", "6.2")


def test_admittance() -> None:
    asked = ("admittance", "--user", "remote", "--frequency", "1e-4", "--frequency", "10")
    found = answer(*asked, "--case", "free", "--round-trip-delay", "1")
    assert found["architecture"] == "centralized"
    slow, fast = found["admittance"]
    assert slow["frame_lifted"]["magnitude"] == pytest.approx(1 / 0.293732, rel=1e-4)
    assert fast["frequency"] == 10
    assert {"magnitude", "phase"} <= fast["fundamental"].keys()
    contact = answer("admittance", "--user", "distributed", "--case", "contact", *asked[3:5])
    assert contact["unit"] == "m/N"
    assert 1 / contact["admittance"][0]["fundamental"]["magnitude"] == pytest.approx(2729.354)
    text = run("admittance", "--architecture", "single", "--frequency", "2")
    assert "fundamental" in text
    assert "belongs to" in refusal(*asked, "--architecture", "distributed")


def test_loss() -> None:
    found = answer("loss", "--architecture", "centralized", "--losses", "together")
    assert 0.3 < found["critical_loss"] < 0.4
    assert answer("loss", "--architecture", "distributed")["critical_loss"] is None
    unstable = ("--architecture", "centralized", "--round-trip-delay", "2")
    assert answer("loss", *unstable)["critical_loss"] == 0
    at = ("--architecture", "centralized", "--loss", "0.05")
    assert answer("loss", *at)["mean_square_stable"]
    assert "unstable" in run("loss", *at, "--burst", "40")
    assert "add --loss" in refusal("loss", *at[:2], "--burst", "3")
    assert "mean burst" in refusal("loss", *at[:2], "--loss", "0.9", "--burst", "2")
    assert "whole number" in refusal("loss", *at[:2], "--ratio", "5/2")


def test_passivity() -> None:
    loop = ("passivity", "--architecture", "single", "--set", "b=1", "--set", "k=1024")
    found = answer(*loop, "--device-damping", "3")
    assert found["needed_device_damping"] == pytest.approx(1.5)
    assert found["passive_stiffness"] == pytest.approx(4096)
    assert found["passive"]
    assert "not passive" in run(*loop, "--device-damping", "1.2")


def test_margins() -> None:
    found = answer("margins", "--architecture", "single")
    assert found["stiffness"][1] == pytest.approx(20.48)
    assert found["network"] is None


def test_design(tmp_path: Path) -> None:
    out = tmp_path / "gains.yaml"
    loop = ("design", "--architecture", "centralized", "--round-trip-delay", "1")
    found = answer(*loop, "--set", "b_1=15", "--set", "b_2=3", "--out", str(out))
    assert found["gains"]["b_1"] == 15
    assert found["compensation"] == 0.0  # a box that nobody holds has nothing else
    assert out.read_text(encoding="utf-8") == found["overlay"]
    overlaid = answer("radius", "--scenario", "single_axis_centralized", "--with", str(out))
    assert overlaid["stable"]
    assert overlaid["parameters"]["k_2"] == pytest.approx(found["gains"]["k_2"], rel=1e-5)
    assert "no network" in refusal("design", "--architecture", "single")
    assert "Take back" in refusal(*loop, "--set", "k_1=100000")
