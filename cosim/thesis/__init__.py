"""Chapter 8 rerun: its experiments, its statements held against measurements, one page."""
