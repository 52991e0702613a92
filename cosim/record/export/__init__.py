"""cosim.record.export.formats"""
