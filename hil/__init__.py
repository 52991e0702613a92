"""Hardware in the loop: device contract, safety layer, drivers, emulators, supervisor.

Everything that reaches a motor goes ``hil.device.Device.write`` -> ``hil.safety.SafetyLayer`` ->
driver. Nothing in here imports ``cosim`` beyond its component protocol and its errors.
"""
