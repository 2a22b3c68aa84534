"""What an idle node costs that has a timer of 10 Hz and nothing else."""

from __future__ import annotations

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node


def main() -> None:
    """Run until killed."""
    rclpy.init()
    node = Node('empty')
    node.create_timer(0.1, lambda: None)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    print('ready: empty', flush=True)
    executor.spin()


if __name__ == '__main__':
    main()
