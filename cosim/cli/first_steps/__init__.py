"""Commands that a newcomer meets first."""
