"""What the thesis and later literature say, what decides it, and what each run says of it."""
