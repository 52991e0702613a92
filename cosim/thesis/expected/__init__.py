"""The limits of the evidence, computed before any run and without the kernel."""
