"""Packets that are lost or late at random: Markov jump systems."""
