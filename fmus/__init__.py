"""The models in plain C, and how they become FMUs."""
