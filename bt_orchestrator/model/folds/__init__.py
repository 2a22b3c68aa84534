"""What each event does to the state; the table of them is `model.fold`."""
