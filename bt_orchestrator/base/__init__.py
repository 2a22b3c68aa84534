"""The ground, which knows no cell: errors, clocks, files, signals, processes."""
