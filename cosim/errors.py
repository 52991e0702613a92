"""The old name of ``cosim.base.errors``; it stays for one release."""

from cosim.base.errors import *  # noqa: F403
