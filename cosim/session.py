"""The old name of ``cosim.run``; it stays for one release."""

from cosim.run import *  # noqa: F403
