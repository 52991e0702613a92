"""Two moteus controllers through their maker's package."""
