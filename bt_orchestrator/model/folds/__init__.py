"""The effect of each event on the state; `model.fold` has the table."""
