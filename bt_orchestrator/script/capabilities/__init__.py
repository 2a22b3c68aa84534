"""What components of a cell file can do: capabilities, workspaces, preparations."""
