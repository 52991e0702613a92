"""A figure as a page for a browser, and the script that it and a run's page are bundled into."""
