"""The run of a line: its tree, its settles, and requests that are made ready for it."""
