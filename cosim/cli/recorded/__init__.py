"""Commands on runs that are there: find, compare, compute again, and tell a device from them."""
