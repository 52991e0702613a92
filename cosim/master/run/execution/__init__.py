"""What a simulation is composed of: start values, FMUs, Python components, the kernel, the loop."""
