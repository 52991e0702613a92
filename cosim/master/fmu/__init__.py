"""An FMU from its archive to a running instance."""
