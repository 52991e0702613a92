"""Co-simulation of cooperative haptics: scenario, schedule, kernel, record, theory, link."""
