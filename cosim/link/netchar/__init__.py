"""Network characterisation: what Table 1.1 of the thesis says, for the user's own network.

``serve`` relays time-tagged packets back, ``probe`` sends them and says what became of them.
"""
