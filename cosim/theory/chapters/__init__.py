"""The thesis's figures and tables as computations, and the page that compares them."""
