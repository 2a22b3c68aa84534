"""Journals: where events become durable."""
