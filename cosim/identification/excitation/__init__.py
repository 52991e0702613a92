"""The motion that tells a device apart: how it is designed inside the limits, and who makes it."""
