"""cosim.master.components"""
