"""Scripts as text: the way back from the model to a file."""
