"""What a script is checked for, after it was read."""
