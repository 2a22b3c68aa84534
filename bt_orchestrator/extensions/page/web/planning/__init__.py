"""A planner's questions: what would become of jobs, and whether an order would be queued."""
