"""Orchestrator for robotic cells: behaviour trees of ROS 2 action clients along a conveyor."""
