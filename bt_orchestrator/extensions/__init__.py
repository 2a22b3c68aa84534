"""Parts that the core works without; `base/extending.py` lists them."""
