"""The terminal: its second screen, and the keys of the person at it."""
