"""tests.unit.fmu_calls"""
