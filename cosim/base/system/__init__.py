"""What is asked of the system: grants, shared pulses, caches, files, installed packages."""
