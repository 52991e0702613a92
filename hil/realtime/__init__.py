"""The paced run: loop, supervisor and recorder in three processes."""
