"""cosim.base.document"""
