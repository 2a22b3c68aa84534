"""Work orders: their files, and where orders of clients are read and bound to scripts."""
