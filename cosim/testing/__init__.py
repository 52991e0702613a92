"""What only tests and benchmarks need: the slow reference loop, and a bad network."""
