"""The live page: a run drawn in a browser, and a pointer that takes a user's place in it.

``scene`` says what a run's signals draw, ``server`` serves the page to who may see it; the page
itself (``page/``) is plain ES modules.
"""
