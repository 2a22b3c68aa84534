"""What is asked of a cell becomes commands to its engine: in one place for every door."""
