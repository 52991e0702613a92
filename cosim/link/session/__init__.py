"""Who the other station is: keys, handshake, contract, and the meeting before the start."""
