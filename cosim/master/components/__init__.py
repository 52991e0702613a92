"""Components before they run: read, made, checked, with the values that they are given."""
