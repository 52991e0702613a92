"""Many runs of one scenario: ``planning`` says which, ``work`` runs them, ``results`` keeps them.

``sweep`` ties the three together.
"""
