"""A small valid scenario that tests change."""

SMALL = """\
cohaptic: 1
title: Two devices and a network
duration: 2 s
rates: {control: 1024, network: 128}
components:
  left: {fmu: pantograph, station: a, rate: control, parameters: {base_x: 0.1}}
  right: {fmu: pantograph, station: b, rate: control}
  third: {fmu: pantograph, station: b, rate: control}
channels:
  lan: {between: [a, b], rate: network, round_trip_delay: 1}
connections:
  - left.joint_angle -> right.motor_torque via lan
  - right.joint_angle -> third.motor_torque
record: [left.*]
expect: {left.energy: {max_below: 1}}
"""
