"""The things that exist, and the events: frozen facts, and the cell's state as their fold.

No input or output, no ROS, no py_trees, no YAML. Everything else depends on this room.
"""
