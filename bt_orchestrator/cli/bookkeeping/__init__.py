"""Books of the account, made for a node in a process of their own."""
