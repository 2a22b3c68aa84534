"""The parts of a journal that do not depend on the database that keeps it."""
