"""What a loaded FMU consists of: where it lives, how it behaves, its texts and its states."""
