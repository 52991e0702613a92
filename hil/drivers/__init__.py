"""One driver a file; each is registered under the entry point group ``cohaptic.devices``."""
