"""What a person sees of a running cell: words, the view of it, and the view on a terminal."""
