"""What a run says: measures, expectations, the summary and the overview figure."""
