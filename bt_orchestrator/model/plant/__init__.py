"""Facts of the plant around a cell, outside of its definition."""
