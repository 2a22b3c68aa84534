"""A node that does nothing: how long its pings take is the fault of the machine."""

from __future__ import annotations

import rclpy
from rclpy.node import Node

NAME = 'plain_node'


def main() -> None:
    """Answer whoever asks for parameters, until killed."""
    rclpy.init()
    node = Node(NAME)
    print(f'plain node ready: /{NAME}', flush=True)  # noqa: T201 - for the parent process
    rclpy.spin(node)


if __name__ == '__main__':
    main()
