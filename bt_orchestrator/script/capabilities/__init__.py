"""The abilities of the components of a cell file: capabilities, workspaces, preparations."""
