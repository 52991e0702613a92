"""A National Instruments card through its maker's package."""
