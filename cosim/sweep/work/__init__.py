"""The runs themselves: one after another in a process, in a pool of them, on a cluster."""
