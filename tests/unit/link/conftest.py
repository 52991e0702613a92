"""The fixtures of ``tests.support.link``."""

from tests.support.link.fixtures import *  # noqa: F403
