"""What ``cohaptic study`` does at a terminal: trials and questions."""
