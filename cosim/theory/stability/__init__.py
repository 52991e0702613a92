"""Spectral radius, stable intervals and maps, margins and passivity."""
