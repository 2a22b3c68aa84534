"""Benchmarks: what the orchestrator costs, and how that grows."""
