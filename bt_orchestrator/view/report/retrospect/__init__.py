"""A job that ran beside the forecast of it."""
