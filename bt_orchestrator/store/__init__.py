"""Journals: where events become durable; `sqlite` keeps them in a file."""
