"""Records and figures, drawings, the terminal: all that a person sees."""
