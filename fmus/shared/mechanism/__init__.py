"""The five-bar linkage, its drives, and the finger that a workstation sees."""
