"""The causes that keep tasks from starting and the belt from moving (semantics 7.4)."""
