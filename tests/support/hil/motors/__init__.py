"""Motors at the other end of a wire, apart from the product's drivers and emulators.

Written from the protocols' descriptions alone. No watchdog drops a torque here: what they note is
what they were told.
"""
