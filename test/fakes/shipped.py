"""Where the shipped files are in the source tree that the tests belong to."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]
TREES = ROOT / 'trees'
RECIPES = ROOT / 'recipes'
REFERENCE_CELL = ROOT / 'config' / 'reference_cell.yaml'
REFERENCE_ORDER = ROOT / 'config' / 'orders' / 'wo_1001.yaml'
REASONS = ROOT / 'config' / 'shifts' / 'reasons.yaml'
STUCK = ROOT / 'test' / 'data' / 'stuck.yaml'
"""A script that gets stuck."""
