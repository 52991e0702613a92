"""From a scenario to wires, an order, a plan and cells; nothing runs yet."""
