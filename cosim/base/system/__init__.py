"""cosim.base.system"""
