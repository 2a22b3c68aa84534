"""Recipes and overrides: their keys, reading them, and what can be known before planning."""
