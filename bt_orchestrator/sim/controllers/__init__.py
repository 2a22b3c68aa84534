"""Simulated controllers: real ROS 2 action servers for every component of a cell file.

What a controller does is plain Python on the `Clock` port (`controller`, `fault_schedule`,
`task_names`, `goal_log`); how it shows itself to ROS 2 is in `task_server`, `state_publisher`,
`component_server` and `node`. Those four, `clock` and `process` import rclpy.
"""
