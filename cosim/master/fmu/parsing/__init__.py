"""From an FMU's XML to its description."""
