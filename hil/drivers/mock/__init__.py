"""The simulated pantograph in this very process."""
