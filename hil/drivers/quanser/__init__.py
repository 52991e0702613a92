"""A Quanser card through its maker's package."""
