"""Everything that is judged before the first tick, for ``run``, ``station`` and ``check`` alike.

What one of them refuses, the others refuse with the same sentence: all three come through
``prepare``. ``check`` goes on to where ``run`` starts the components, in a process of its own.
"""
