"""How the command ``run`` runs one scenario, or several one after another."""
