"""The interfaces of the tree node: services, topics, an action."""
