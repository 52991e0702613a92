"""The old name of ``cosim.base.component``; it stays for one release."""

from cosim.base.component import *  # noqa: F403
