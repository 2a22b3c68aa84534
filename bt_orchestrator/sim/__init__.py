"""The cell without the cell: virtual time, and simulated controllers."""
