"""The verb `demo`, and what it starts and shows."""
