"""Tools for a program with a loop of its own that stands at the door of a cell.

Two threads with a door each: one follows, one asks. Commands are done once, by their tickets. The
page and the OPC UA server are made of it.
"""
