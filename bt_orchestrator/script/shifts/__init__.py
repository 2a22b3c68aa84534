"""The file of shifts: when the cell is meant to work."""
