"""Motors at the other end of a wire, apart from the product's drivers and emulators.

Written from the protocols' descriptions alone. They have watchdogs, which report and switch off;
but what they note is what they were told, so a watchdog makes no zero here.
"""
