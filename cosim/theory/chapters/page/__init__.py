"""``docs/thesis.md``, chapter by chapter."""
