"""Commands on runs that are there: find, compare and compute them again."""
