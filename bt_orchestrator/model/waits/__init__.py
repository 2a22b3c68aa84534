"""What keeps tasks from starting and the belt from moving: one teller for all (semantics 7.4)."""
