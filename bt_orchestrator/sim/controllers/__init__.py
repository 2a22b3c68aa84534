"""Simulated controllers behind real ROS 2 action servers, one for each component of a cell file.

What a controller does is in `sim.controller`, the same as in virtual time. Here is what carries
its messages: `component_server` with its `task_server` and `state_publisher`, on a `node`. Those
four, `clock` and `process` import rclpy.
"""
