"""The robots: action clients, goals, state topics."""
