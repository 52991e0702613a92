"""What came out: kept by content, as a table, as a picture."""
