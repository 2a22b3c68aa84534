"""One of two processes that try whether they find each other and exchange a message.

    python -m bt_orchestrator.ros.diagnosis.participant ask|answer TOPIC SECONDS

The one that asks prints as JSON the seconds until it found the other one, and from there until the
answer; null if none came.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

from bt_orchestrator.ros.diagnosis.exchange import NOTHING

STEP_S = 0.02


def ask(node: Node, topic: str, spin: Callable[[], bool]) -> bool:
    """Wait for the other one, say something, and wait for the answer."""
    started = time.monotonic()
    heard: list[String] = []
    node.create_subscription(String, f'{topic}/answer', heard.append, 10)
    publisher = node.create_publisher(String, f'{topic}/question', 10)
    while not (publisher.get_subscription_count() and node.count_publishers(f'{topic}/answer')):
        if not spin():
            return False
    found = asked = time.monotonic()
    while not heard:
        # Said again: the answer's way back may be known a moment later.
        publisher.publish(String(data='?'))
        if not spin():
            break
    times = [found - started, time.monotonic() - asked if heard else None]
    sys.stdout.write(json.dumps(times))
    return bool(heard)


def answer(node: Node, topic: str, spin: Callable[[], bool]) -> bool:
    """Answer everything that is asked, until the time is over."""
    publisher = node.create_publisher(String, f'{topic}/answer', 10)
    node.create_subscription(String, f'{topic}/question', publisher.publish, 10)
    while spin():
        pass
    return True


def main(role: str, topic: str, seconds: str) -> int:
    """Take part; returns the exit status."""
    rclpy.init()
    node = Node('bt_orchestrator_doctor', start_parameter_services=False, enable_rosout=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    deadline = time.monotonic() + float(seconds)

    def spin() -> bool:
        executor.spin_once(timeout_sec=STEP_S)
        return time.monotonic() < deadline

    done = {'ask': ask, 'answer': answer}[role](node, topic, spin)
    rclpy.try_shutdown()
    return 0 if done else NOTHING


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
