"""The proof that a line cannot get stuck, or where it would, without a run (semantics 8.2)."""
