"""What a machine needs to run devices, looked at one by one, with what to do about each."""
