"""Simulation: virtual time, and simulated controllers."""
