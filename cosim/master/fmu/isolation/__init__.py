"""An FMU in a process of its own: the memory that both share, and either side of it."""
