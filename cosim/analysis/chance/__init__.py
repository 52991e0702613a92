"""Runs whose packets are lost or late by chance: fates, their chain, their maps, second moments."""
