"""The fixtures of ``tests.support.record``."""

from tests.support.record.fixtures import *  # noqa: F403
