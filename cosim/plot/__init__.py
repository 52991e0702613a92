"""Figures of recorded signals: over time, difference, spectrum, phase plane, histogram."""
