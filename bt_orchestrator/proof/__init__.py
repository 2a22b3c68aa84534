"""Why a line cannot get stuck, or where it would: decided without a run (semantics 8.2)."""
