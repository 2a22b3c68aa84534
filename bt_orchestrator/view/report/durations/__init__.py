"""How long tasks take against their nominal times, and since when they take longer."""
