"""What the tree node offers: services, topics, an action."""
