"""YAML to model: reading with positions, and every check that needs no motion."""
