"""Fuzzing of everything that reads bytes from outside: targets, and the command that runs them.

A target is a function of some bytes that raises where a claim does not hold. The default test
suite feeds it from Hypothesis, ``uv run --group fuzz python -m tests.fuzz`` from a fuzzer that is
guided by coverage.
"""
