"""The fixtures of ``tests.support.scenario``."""

from tests.support.scenario.fixtures import *  # noqa: F403
