"""System Structure and Parameterization (SSP 1.0 and 2.0) and OSP system structures.

Read into the document of a scenario, and written from one; ``schema`` holds the standard's own.
"""
