"""The behaviour tree: compiling the model, and the behaviours.

The tree holds no progress: every behaviour reads from the state whether its task is new, in flight
or done, and records its decisions as events.
"""
