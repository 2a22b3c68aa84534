"""Verbs that ask something of a running cell, made from the declarations of requests."""
