"""The record of one item: all that happened to it, why it waited, and what stood beside it."""
