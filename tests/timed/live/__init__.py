"""The live page beside a loop that keeps its pace."""
