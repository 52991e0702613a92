"""What the commands about FMUs share: their report, a check, a new model, one that runs alone."""
