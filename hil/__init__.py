"""Hardware in the loop: device contract, safety layer, drivers, emulators, supervisor.

Everything that reaches a motor goes from ``Device.write`` through the safety layer to the driver.
"""
