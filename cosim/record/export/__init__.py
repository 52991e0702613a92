"""A run in other formats: CSV, MAT, Parquet, MF4 and MCAP."""
