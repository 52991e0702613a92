"""What a device is, from what it did: inertia, friction, delay, offset and gain out of its runs.

``five_bar`` and ``regressor`` are derived here from the Lagrangian alone, apart from the models
that simulate devices, so that the one can tell on the other.
"""
