"""The ground floor: errors, places, units, variables, YAML with places, and what a recorder is.

Nothing in here knows a scenario, a master, a device or a model; everything else may import it.
"""
