"""The other end: a running tree node as its clients see it."""
