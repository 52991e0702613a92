"""One workstation of a scenario: its own components under the master, the others behind links.

The only place that knows both the master and the link.
"""
