"""``report.html``: one page of a run that opens from a file and needs nothing else."""
