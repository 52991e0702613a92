"""Fixtures of the link's tests."""

from __future__ import annotations

import pytest

from tests.support.link.support import Pair, make_pair


@pytest.fixture
def pair() -> Pair:
    return make_pair()
