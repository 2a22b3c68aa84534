"""Conditions of tasks: their keys, and reading them (semantics 6.5)."""
