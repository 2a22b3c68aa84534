"""Turns requests to a cell into commands to its engine, in one place for every interface."""
