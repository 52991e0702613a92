"""The fixtures of ``tests.support.hil``."""

from tests.support.hil.fixtures import *  # noqa: F403
