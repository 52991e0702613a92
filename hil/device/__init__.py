"""A device from its declared facts to two calls a tick, with its latch and its lifecycle."""
