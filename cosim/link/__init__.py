"""UDP between workstations: packet, keys, handshake, clock, loss of the peer, network measurement.

Everything that touches time takes it as an argument, so that tests run hours in seconds.
"""
