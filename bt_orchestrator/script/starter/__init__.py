"""The output of `new-cell`: a cell, and a first script and order for it."""
