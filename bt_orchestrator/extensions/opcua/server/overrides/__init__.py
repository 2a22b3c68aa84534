"""asyncua's server where it would let in too much, keep too much, or answer what is not so.

Each override has its reason beside it, and a test that fails without it (docs/decisions/0037).
"""
