"""Checks that need ROS 2: its versions, discovery tried for real, and a cell's graph."""
