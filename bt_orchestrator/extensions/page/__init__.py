"""The operator page: its server and files, and its verb."""
