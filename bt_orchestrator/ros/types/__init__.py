"""What the installed interfaces say of their types, and messages from plain values and back."""
