"""The types in the installed interfaces, and messages from plain values and back."""
