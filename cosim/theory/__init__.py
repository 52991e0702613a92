"""Chapters 3 to 6 as code: discretisation, multi-rate models, stability, transparency, loss, design.

Imports NumPy and SciPy alone; everything is in SI units, and delays are whole network samples.
"""
