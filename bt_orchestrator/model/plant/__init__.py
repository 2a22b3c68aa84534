"""What belongs to the plant around a cell, and is no part of its definition."""
