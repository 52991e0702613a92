"""Numbers with units: one table of units, and quantities that are exact until they are floats."""
