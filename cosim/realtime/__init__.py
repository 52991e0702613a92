"""The paced run: command, supervisor and control loop in three processes.

Pacing and deadlines, the rings between the processes, what others may watch of a run.
"""
