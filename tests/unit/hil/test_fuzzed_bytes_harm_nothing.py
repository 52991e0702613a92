"""Every parser's claims hold for whatever bytes Hypothesis thinks of; see tests/fuzz."""

from __future__ import annotations

import json
from math import inf, nan

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hil.drivers.haply import protocol as haply
from hil.drivers.haply.emulator import HaplyBoard
from hil.emulation.world import World
from tests.fuzz.file_targets import WORDS, document_is_refused_or_right
from tests.fuzz.seeds import DEVICE_FILE
from tests.fuzz.targets import SEEDS, TARGETS
from tests.fuzz.wire import Rest

fixed = settings(
    deadline=None,
    max_examples=60,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
"""The same bytes every time: looking for new ones is what ``python -m tests.fuzz`` is for."""
plain = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
documents = st.recursive(
    plain | st.sampled_from(WORDS),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(WORDS) | st.text(max_size=4), inner, max_size=8)
    ),
    max_leaves=30,
)


@pytest.mark.parametrize("target", TARGETS)
def test_claim(target: str):
    @fixed
    @given(st.binary(max_size=400))
    def holds(data: bytes) -> None:
        TARGETS[target](data)

    for seed in SEEDS.get(target, ()):
        TARGETS[target](seed)
    holds()


@fixed
@given(documents)
def test_a_document_is_a_device_file_or_refused(document):
    document_is_refused_or_right(document)


@fixed
@given(st.integers(0, len(DEVICE_FILE)), st.sampled_from(WORDS) | plain.map(str), st.integers(0, 9))
def test_a_device_file_with_something_wrong_in_it_is_refused_or_right(place, word, lost):
    text = DEVICE_FILE[:place] + word.encode("utf-8", "replace") + DEVICE_FILE[place + lost :]
    TARGETS["device_file_text"](text)


@fixed
@given(documents)
def test_an_emulator_answers_whatever_it_is_asked(document):
    asked = {"do": "fault", "kind": "drop", **document} if isinstance(document, dict) else document
    for request in (document, asked, {"do": "shift", "by": document}):
        TARGETS["side_channel"](json.dumps(request).encode())


@pytest.mark.parametrize("counts", [nan, inf, -inf, 0.0, 1e-45, 3e38])
def test_a_setup_with_any_resolution_is_answered(counts):
    """Found by the fuzzer: a resolution that is no number ended the emulator."""
    board = HaplyBoard(World(Rest((1.0, 2.0)), lockstep=False))
    axes = [haply.HaplyAxis(port=2, counts_per_turn=counts), haply.HaplyAxis(port=1)]
    board.receive(haply.reset(5) + haply.setup(5, axes))
    (answer,) = board.receive(haply.torques(5, axes, (0.0, 0.0)))
    assert len(answer) == haply.REPLY_BYTES
