"""Chapters 3 to 6 as code: multi-rate models, stability, transparency, packet loss, design.

Imports NumPy and SciPy alone; everything is in SI units, and delays are whole network samples.
"""
