"""The users of pages and OPC UA servers, with their roles (docs/security.md)."""
