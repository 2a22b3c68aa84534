"""Model to behaviour tree: compiling, and the behaviours it compiles to.

The tree holds no progress: every behaviour asks the state whether its task is new, in flight or
done, and records what it decides as events.
"""
