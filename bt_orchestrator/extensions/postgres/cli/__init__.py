"""The verb `feed`."""
