"""Work orders, the jobs they become, and what may be asked of them."""
