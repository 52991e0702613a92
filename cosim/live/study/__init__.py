"""What the page of a study has besides that of a run."""
