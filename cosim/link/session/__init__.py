"""Who the other station is: keys, handshake, contract, and how stations agree on a start."""
