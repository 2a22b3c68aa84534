"""What tells items and orders apart: serials, lots, and the ids that were ever used."""
