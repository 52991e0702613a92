"""What the pages of docs/ show, made from what it is about."""
