"""The old name of ``hil.safety.component``; it stays for one release."""

from hil.safety.component import *  # noqa: F403
