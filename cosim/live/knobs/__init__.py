"""What a page may turn while a scenario is played, and how it comes into the run."""
