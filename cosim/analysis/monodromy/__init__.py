"""The map of the run itself over one hyperperiod: what the theory says of exactly this scenario.

The compiled plan is run from states that differ in one number, and differences make the matrix.
"""
