"""The forms that a document is read into: every key, its type and its meaning."""
