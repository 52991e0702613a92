"""Every key of every form, and what a key changes when a scenario really runs."""
