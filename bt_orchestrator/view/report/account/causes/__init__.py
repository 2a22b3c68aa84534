"""The output, why items are not good, what was done again, and what was measured."""
