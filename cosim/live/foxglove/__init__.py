"""A run that goes on, for Foxglove and what speaks its WebSocket protocol.

``protocol`` is the wire, ``channels`` what a run offers, ``client`` one viewer that is connected.
"""
