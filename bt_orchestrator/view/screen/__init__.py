"""The view of a person on a running cell: words, the view of it, and the view on a terminal."""
