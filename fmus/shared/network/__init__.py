"""What a workstation sends and receives: packets, waves, passivity."""
