"""Gains that follow from a network, and the corners that they are promised to stand."""
