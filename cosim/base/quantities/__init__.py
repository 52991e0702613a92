"""cosim.base.quantities"""
