"""Recipes: reading them, planning, and the scripts generated from them."""
