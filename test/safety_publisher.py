"""Publishes a safety input as a safety controller would, in a process of its own, for tests.

    python safety_publisher.py FILE

FILE has what is published: true, false, or nothing, which is silence.
"""

from __future__ import annotations

import sys
from pathlib import Path

PERIOD_S = 0.05


def main() -> None:
    """Publish until it is killed."""
    import rclpy
    from rclpy.clock import Clock
    from rclpy.clock_type import ClockType
    from std_msgs.msg import Bool

    file = Path(sys.argv[1])
    rclpy.init()
    node = rclpy.create_node('safety_controller')
    publisher = node.create_publisher(Bool, '/safety/ok', 1)

    def publish() -> None:
        value = file.read_text().strip()
        if value:
            publisher.publish(Bool(data=value == 'true'))

    node.create_timer(PERIOD_S, publish, clock=Clock(clock_type=ClockType.STEADY_TIME))
    sys.stdout.write('safety publisher ready: /safety/ok\n')
    sys.stdout.flush()
    rclpy.spin(node)


if __name__ == '__main__':
    main()
