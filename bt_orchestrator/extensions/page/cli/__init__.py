"""The verb `page`, and what it is made of."""
