"""What `new-cell` writes: a cell, and a first script and order for it."""
