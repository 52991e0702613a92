"""What is varied and which points are run: from a file or options to a job and its points."""
