"""Checks of the machine that a cell is to run on; nothing here needs ROS 2 (see ros/diagnosis)."""
