"""What Foxglove and PlotJuggler read: the scene as entities, record rows as ROS 2 messages.

The export of a record (``cosim.record.export``) and the live server (``cosim.live.foxglove``) send
the same messages on the same topics, so that one layout fits both.
"""
