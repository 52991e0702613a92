"""What the CANopen driver is made of: which node is what, setting up, supervision, zero read back.

The frames are in ``hil.protocols.canopen``, the driver in ``hil.drivers.canopen``.
"""
