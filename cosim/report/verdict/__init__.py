"""What a scenario's expectations come to: read before a run, judged after it.

A verdict needs what it speaks of: where that is lacking it is not met, and says what is.
"""
