"""Everything before the loop: device file, address, calibration, registry, first looks."""
