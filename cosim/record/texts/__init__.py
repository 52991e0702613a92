"""Recorded texts and binary values: a journal while the run goes on, a file when it is over."""
