"""Everything that speaks ROS 2; only entry points import it."""
