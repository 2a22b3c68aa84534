"""Who may log in at pages and OPC UA servers, with which role (docs/security.md)."""
