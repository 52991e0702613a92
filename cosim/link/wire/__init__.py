"""Bytes: the packet and its seal, the socket, and the kernel's filter."""
