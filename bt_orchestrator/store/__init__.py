"""Journals, which make events durable; `sqlite` keeps them in a file."""
