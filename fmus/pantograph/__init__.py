"""The planar five-bar haptic device: mechanism, motors, amplifiers, DAC and encoders."""
