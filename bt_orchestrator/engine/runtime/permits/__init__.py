"""Permits besides the rules of the line: who may move it, from where, with which components."""
