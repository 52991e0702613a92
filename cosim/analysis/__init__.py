"""Between a scenario and the theory: what chapters 3 to 6 say about the scenario at hand."""

from cosim.analysis.compensation import load_tuned

__all__ = ["load_tuned"]
