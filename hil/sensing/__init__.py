"""Devices that measure and push nothing: what a sensor is, its file, its component."""
