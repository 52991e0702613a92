"""One station's half of a scenario: its own components, and a link in place of everything else."""

from __future__ import annotations

import json
import re
import textwrap

import pytest

from cosim import reading
from cosim.base.errors import InputError
from cosim.link.session.contract import Contract
from cosim.link.stream.form import read_link
from cosim.link.stream.peer_link import PeerLink
from cosim.link.stream.remote import Grid, RemoteStation
from cosim.link.wire.address import Address
from cosim.master.assembly.assemble import Assembly, put_together
from cosim.record import open_run
from cosim.run import run_scenario
from cosim.scenario import load
from cosim.scenario.source.bundled import bundled_scenarios
from cosim.station.contract import contract_of
from cosim.station.halves import refuse_unusable_halves
from cosim.station.partners import addresses_of, key_files_of
from cosim.station.split import split

ADD = "add_impairments: true"


@pytest.fixture(scope="module", name="box")
def _box():
    return put_together(load("two_users_box"))


@pytest.fixture(scope="module", name="centralized")
def _centralized():
    return put_together(load("two_users_box_centralized"))


def contract(assembly, own: str) -> Contract:
    half = split(assembly, own)
    return Contract(contract_of(assembly, half, half.peers[0]))


def test_each_half_keeps_its_own_components_and_connections(box) -> None:
    for own, other in (("station_a", "station_b"), ("station_b", "station_a")):
        half = split(box, own)
        assert [peer.name for peer in half.peers] == [other]
        stations = {c.station for c in half.scenario.components.values()}
        assert stations == {own}
        assert f"link_{other}" in half.scenario.components
        inner = [c for c in half.scenario.connections if f"link_{other}" not in str(c)]
        assert len(inner) == 10
        assert half.scenario.channels == {}


def test_a_half_turns_its_own_components_and_no_channel() -> None:
    event = {"vr_a.compensation.x": -1, "vr_b.compensation.x": -2}
    events = f"events=[{{at: 1 s, set: {json.dumps(event)}}}]"
    both = put_together(load("two_users_box", sets=[events]))
    for own, value in (("a", -1), ("b", -2)):
        turned = split(both, f"station_{own}").scenario.events
        assert [(str(e.target), e.value) for e in turned] == [(f"vr_{own}.compensation.x", value)]
    for sets in ("events=[{at: 1, set: {lan.loss: 1 %}}]", "knobs={lan.loss: {maximum: 0.3}}"):
        half = split(put_together(load("two_users_box", sets=[sets])), "station_a")
        turned = ("what turns lan.backward.loss", "what turns lan.forward.loss")
        assert half.dropped[:2] == turned
        assert half.scenario.events == half.scenario.knobs == ()


def test_what_one_sends_the_other_receives_in_the_same_order(box, centralized) -> None:
    for assembly in (box, centralized):
        a, b = (split(assembly, own) for own in assembly.scenario.stations)
        for here, there in ((a, b), (b, a)):
            sent = [bundle.describe() for bundle in here.peers[0].sends]
            received = [bundle.describe() for bundle in there.peers[0].receives]
            assert sent == received
            assert sum(bundle.size for bundle in here.peers[0].sends) > 10


def test_weight_validity_and_age_drive_the_workstations_inputs(box, centralized) -> None:
    half = split(box, "station_a")
    driven = {str(c) for c in half.scenario.connections}
    assert {
        "link_station_b.lan.weight -> vr_a.peer_weight[1]",
        "link_station_b.lan.valid -> vr_a.peer_valid[1]",
        "link_station_b.lan.age -> vr_a.peer_age[1]",
    } <= driven
    for own in centralized.scenario.stations:
        targets = [str(c.target) for c in split(centralized, own).scenario.connections]
        assert any(target.endswith("peer_weight[1]") for target in targets)


def test_the_two_halves_agree_on_the_contract(box) -> None:
    assert contract(box, "station_a").hash == contract(box, "station_b").hash


@pytest.mark.parametrize(
    ("change", "agree"),
    [
        ("components.vr_a.parameters.local_normal_stiffness=801", False),
        ("components.vr_b.parameters.coupling_stiffness=70", False),
        ("rates.network=64 Hz", False),
        ("components.vr_a.parameters.finger_1.base_x=-0.08", True),
        ("components.operator_a1.parameters.via_count=4", True),
        ("channels.lan.round_trip_delay=3", True),
        ("duration=3 s", True),
    ],
)
def test_what_matters_to_the_peer_is_in_the_contract_and_nothing_else(box, change, agree) -> None:
    other = put_together(load("two_users_box", (), (change,)))
    mine, theirs = contract(box, "station_a"), contract(other, "station_b")
    assert (mine.hash == theirs.hash) is agree
    assert bool(mine.difference(theirs.entries, "a", "b")) is not agree


def test_with_impairments_on_top_the_channel_stays_for_what_comes_in(box) -> None:
    sets = ("channels.lan.link={add_impairments: true}",)
    half = split(put_together(load("two_users_box", (), sets)), "station_b")
    channel = half.scenario.channels["lan"]
    assert channel.direction("station_a", "station_b").delay.ticks == 8
    assert channel.direction("station_b", "station_a").delay.ticks == 0
    ends = {c: (c.source.component, c.target.component) for c in half.scenario.connections}
    assert {c.via for c, between in ends.items() if "link_station_a" in between} == {"lan"}


def two_channels(tmp_path, first: str, second: str, more: str = "") -> Assembly:
    """Two users whose positions go through two channels, with these settings."""
    text = f"""
        cohaptic: 1
        duration: 1
        components:
          one: {{fmu: hand, station: station_a, rate: 1024}}
          two: {{fmu: hand, station: station_a, rate: 1024}}
          there: {{fmu: hand, station: station_b, rate: 1024}}
          other: {{fmu: hand, station: station_b, rate: 1024}}
        channels:
          fast: {{between: [station_a, station_b], rate: 128, link: {first}}}
          slow: {{between: [station_a, station_b], rate: 32, each_way_delay: 2, link: {second}}}
        connections:
          - {{from: one.position, to: there.force, via: fast, unit: ignore{more}}}
          - {{from: two.position, to: other.force, via: slow, unit: ignore{more}}}
    """
    file = tmp_path / "two_channels.yaml"
    file.write_text(textwrap.dedent(text).lstrip(), encoding="utf-8")
    return put_together(load(file))


def contracts(assembly: Assembly) -> set[bytes]:
    halves = [split(assembly, own) for own in ("station_a", "station_b")]
    return {Contract(contract_of(assembly, half, half.peers[0])).hash for half in halves}


@pytest.mark.parametrize(
    ("first", "second"), [("clock: free", "clock: follow"), (ADD, "add_impairments: false")]
)
def test_all_channels_between_two_stations_are_one_link(tmp_path, first, second) -> None:
    mixed = two_channels(tmp_path, f"{{{first}}}", f"{{{second}}}")
    said = f"the channels fast and slow both lead to station_b, and one says {first}, the other"
    with pytest.raises(InputError, match=re.escape(said)):
        split(mixed, "station_a")


def test_who_only_sends_knows_of_the_clock_too(tmp_path) -> None:
    free = two_channels(tmp_path, "{clock: free}", "{clock: free}")
    halves = [split(free, own) for own in ("station_a", "station_b")]
    assert [half.peers[0].clock for half in halves] == ["free", "free"]
    assert len(contracts(free)) == 1


@pytest.mark.parametrize("settings", ["{}", f"{{{ADD}}}"])
def test_a_station_makes_of_a_value_what_its_connection_says(tmp_path, settings) -> None:
    more = ", factor: 2.5, offset: -1, rate: 64, initial: start"
    whole = two_channels(tmp_path, settings, settings, more.replace("64", "32"))
    refuse_unusable_halves(whole)
    half = split(whole, "station_b")
    linked = [c for c in half.scenario.connections if c.target.path == "force"]
    assert [(c.factor, c.offset, c.ignores_unit) for c in linked] == [(2.5, -1.0, True)] * 2
    real = settings == "{}"
    assert [c.rate for c in linked] == [None if real else 32] * 2
    assert [c.initial for c in linked] == ["source" if real else "start"] * 2
    told = [sentence for sentence in half.dropped if "initial: start" in sentence]
    assert len(told) == (2 if real else 0)


def test_what_a_connection_makes_of_a_value_is_in_the_contract(tmp_path) -> None:
    plain, twice = (two_channels(tmp_path, "{}", "{}", more) for more in ("", ", factor: 2"))
    assert len(contracts(plain)) == len(contracts(twice)) == 1
    assert contracts(plain) != contracts(twice)


def test_what_is_expected_of_the_whole_is_left_out_and_said() -> None:
    sets = ["expect={lan.forward.age: {max: 20}, vr_b.drift: {max: 1 m}, drift: {below: 1 mm}}"]
    both = put_together(load("two_users_box", sets=sets))
    for own, kept in (("station_a", []), ("station_b", ["vr_b.drift"])):
        half = split(both, own)
        assert list(half.scenario.expect) == kept
        (said,) = [text for text in half.dropped if text.startswith("expect ")]
        assert {"lan.forward.age", "drift"} <= set(said[7:].split(", "))
        assert "vr_b" not in said


def test_records_of_other_stations_are_left_out_and_said(box) -> None:
    half = split(box, "station_a")
    patterns = [record.pattern for record in half.scenario.record]
    assert not any(pattern.startswith(("vr_b", "finger_b", "lan")) for pattern in patterns)
    assert "link_station_b.lan.weight" in patterns
    assert all(text.startswith(("record ", "expect ")) for text in half.dropped)


def test_mistakes_are_sentences(box) -> None:
    with pytest.raises(InputError, match=r"no station 'station_c'\. Did you mean"):
        split(box, "station_c")
    single = put_together(load("single_user"))
    with pytest.raises(InputError, match="nothing crosses a channel"):
        split(single, single.scenario.stations[0])
    with pytest.raises(InputError, match="--peer station_b=host:port"):
        addresses_of("station_a", ["station_b"], {})
    with pytest.raises(InputError, match=r"'station_d' is no peer.*Did you mean station_b"):
        addresses_of("station_a", ["station_b"], {"station_d": Address("127.0.0.1", 1)})
    address = Address("127.0.0.1", 1)
    for given in ({"": address}, {"station_b": address}):
        assert addresses_of("station_a", ["station_b"], given) == [address]


def test_every_pair_has_a_key_of_its_own(tmp_path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    both = ["station_b", "station_c"]
    assert key_files_of("station_a", ["station_b"], {"": one}) == [one]
    assert key_files_of("station_a", both, {"station_c": two, "station_b": one}) == [one, two]
    assert key_files_of("station_a", both, {}) == [None, None]
    with pytest.raises(InputError, match="each of them could speak in another's name"):
        key_files_of("station_a", both, {"": one})
    with pytest.raises(InputError, match="two peers have one key file"):
        key_files_of("station_a", both, {"station_c": one, "station_b": one})
    with pytest.raises(InputError, match=r"'station_x' is no peer of station_a"):
        key_files_of("station_a", both, {"station_x": one})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"holdsamples": 4}, "unknown key 'holdsamples'. Did you mean hold_samples?"),
        (
            {"release": "soon"},
            "release: this must be 'network_tick' or 'arrival', not the text 'soon'",
        ),
        ({"delay": 0}, "delay: 0 is out of range: at least 1"),
        ({"fade": "-1 s"}, "fade: the text '-1 s' is out of range: more than 0 s"),
        ({"add_impairments": "yes"}, "add_impairments: this must be true or false"),
        (
            {"release": "arrival", "delay": 3},
            "release: arrival shows values as they come, and delay: 3 lets them wait",
        ),
        ({"release": "arrival", "delay": "auto"}, "and delay: auto lets them wait"),
        (
            {"delay": 8, "max_delay": 4},
            "max_delay 4 is less than delay 8: every packet waits longer than it may",
        ),
    ],
)
def test_link_settings_are_checked(options, message) -> None:
    with pytest.raises(InputError) as caught:
        read_link(options, "channel lan")
    assert message in str(caught.value)


def test_link_settings_are_read() -> None:
    options = {"max_delay": 3, "delay": 2, "fade": "20 ms", "resume": 0.5, "clock": "free"}
    settings = read_link(options, "channel lan")
    assert (settings.max_delay, settings.delay, settings.clock) == (3, 2, "free")
    assert (settings.fade, settings.resume) == (0.02, 0.5)


class Nobody:
    """A transport on which nothing ever comes."""

    def receive(self, buffer: memoryview) -> int:
        return -1

    def arrival(self) -> int:
        return 0

    def send(self, datagram: memoryview | bytes) -> bool:
        return True

    def discard(self) -> int:
        return 0


@pytest.mark.parametrize("delay", [None, 1, 3])
@pytest.mark.parametrize("own", ["station_a", "station_b"])
def test_the_age_that_the_workstation_is_told_holds_all_delays(tmp_path, own, delay) -> None:
    """A silent peer is as old as the run, however many samples the simulated channel adds."""
    sets = [f"record=[{own.replace('station', 'vr')}.peer_age]"]
    if delay is not None:
        on_top = f"{{each_way_delay: {delay}, round_trip_delay: null, link: {{{ADD}}}}}"
        sets.append(f"channels.lan={on_top}")
    full = put_together(load("two_users_box", (), (*sets, "duration=0.05 s")))
    half = split(full, own)
    (peer,) = half.peers
    link = PeerLink(
        sends=peer.sends,
        receives=peer.receives,
        settings=peer.settings,
        transport=Nobody(),
        forward=lambda *_: None,
    )
    grid = Grid(tick_ns=1e9 / 1024)
    remote = RemoteStation(link, grid=grid, now=lambda: 0)
    made = {peer.component: remote}
    finished = run_scenario(half.scenario, tmp_path / "run", figure=False, instances=made)
    with open_run(finished.folder) as run:
        age = run[f"vr_{own[-1]}.peer_age[1]"].values
    begins = 0 if delay is None else 8 * delay
    assert len(age) == 52
    assert list(age[begins:]) == list(range(begins, len(age)))


def test_what_is_expected_of_two_stations_is_judged_at_neither() -> None:
    """A difference begins with a component of one of them, and a length with a stroke."""
    both = "vr_a.finger_1.normal_force - vr_b.finger_1.normal_force"
    alone = "|vr_b.finger_1.force|"
    sets = [f'expect={{"{both}": {{max: 1 N}}, "{alone}": {{max: 9 N}}}}']
    whole = put_together(load("two_users_box", sets=sets))
    halves = [split(whole, station) for station in ("station_a", "station_b")]
    assert [list(half.scenario.expect) for half in halves] == [[], [alone]]
    for half in halves:
        assert any(both in text for text in half.dropped)


@pytest.mark.slow
@pytest.mark.parametrize("name", [each.name for each in bundled_scenarios()])
def test_every_bundled_scenario_has_stations_that_could_run_it(name: str) -> None:
    """``cohaptic check`` refuses what a station would."""
    refuse_unusable_halves(put_together(reading.load(name)))
