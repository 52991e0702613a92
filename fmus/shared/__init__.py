"""C that several models share, and the variable groups that go with it."""
