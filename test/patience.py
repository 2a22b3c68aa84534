"""How long tests wait for what must come."""

PATIENCE_S = 120.0
"""Deadline of a condition: far more than it takes, also on a slow and busy machine."""
