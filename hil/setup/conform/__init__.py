"""The conformance suite: what a board and its driver have to do, tried on a lab's own bench."""
