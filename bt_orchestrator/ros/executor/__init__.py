"""The executor of the tree node: one thread, and what wakes it."""
