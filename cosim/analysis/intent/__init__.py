"""Where a hand will be between packets: the filter, its fit to recordings, and what it is worth."""
