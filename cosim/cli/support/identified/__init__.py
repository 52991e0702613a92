"""What the command ``identify`` finds out about devices before it looks at their motion."""
