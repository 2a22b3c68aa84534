"""The verb `journal`."""
