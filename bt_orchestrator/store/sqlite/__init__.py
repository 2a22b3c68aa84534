"""A journal in an SQLite file, and reading one."""
