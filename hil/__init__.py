"""Hardware in the loop: device contract, safety layer, drivers, emulators, supervisor."""
