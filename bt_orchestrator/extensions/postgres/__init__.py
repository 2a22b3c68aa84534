"""The plant's database: many cells in one PostgreSQL. psycopg is used here only."""
