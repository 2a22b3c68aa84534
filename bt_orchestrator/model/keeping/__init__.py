"""The state as data that can be kept: as JSON, exactly, and written in slices."""
