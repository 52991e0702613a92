"""The loop in C, its structures as Python sees them, and the program that it runs."""
