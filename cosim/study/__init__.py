"""Studies with people: conditions in a counterbalanced order, trials, questions, one tidy table."""
