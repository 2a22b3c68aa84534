"""The checks of a script after it was read."""
