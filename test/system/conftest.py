"""Fixtures of the system tests."""

from cell_fixtures import fast_discovery, small_cell, small_cell_file, start_cell

__all__ = ['fast_discovery', 'small_cell', 'small_cell_file', 'start_cell']
