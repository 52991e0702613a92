"""What the theory's commands share: their options, and what they say of a run."""
