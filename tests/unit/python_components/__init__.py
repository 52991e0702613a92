"""tests.unit.python_components"""
