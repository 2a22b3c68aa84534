"""One of two processes that try whether they find each other and exchange a message.

    python -m bt_orchestrator.ros.diagnosis.participant ask|answer TOPIC SECONDS

The one that asks prints as JSON the seconds until it found the other one, and from there until the
answer; null if none came.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Mapping
from typing import NamedTuple

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn

NAME = 'discovery'
PATIENCE_S = 10.0
"""Longest time that two processes get to find each other."""
START_S = 30.0
"""Longest time for a process to start and to end, beyond that."""
SLOW_S = 5.0

NOTHING = 3
"""Exit status of a process that asked and was not answered."""

_ONLY_THIS_COMPUTER = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_LOCALHOST_ONLY': '0'}


class Times(NamedTuple):
    """The outcome, in seconds; None: there was none."""

    found: float | None = None
    answered: float | None = None
    broken: str = ''
    """Why the processes could not even try."""


def discovery() -> Check:
    """Let two processes find each other, as the environment says; if not, on this computer."""
    times = exchange({})
    if times.found is not None and times.answered is not None:
        words = f'{times.found:.1f} s to find each other, {1000 * times.answered:.0f} ms to answer'
        summary = f'two processes: {words}'
        remedy = 'every start takes that long; is the network interface up, the machine idle?'
        return warn(NAME, summary, remedy) if times.found > SLOW_S else ok(NAME, summary)
    if times.broken:
        return fail(NAME, f'not tried: {times.broken}', 'a ROS 2 process cannot start here')
    if times.found is not None:
        remedy = (
            'UDP or shared memory is blocked: look at the firewall and at /dev/shm (files of '
            'another user?), or try FASTDDS_BUILTIN_TRANSPORTS=UDPv4, which does nothing with '
            'ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST'
        )
        return fail(NAME, 'two processes found each other, and no message came', remedy)
    return fail(NAME, 'two processes here do not find each other', _remedy())


def _remedy() -> str:
    if exchange(_ONLY_THIS_COMPUTER).answered is not None:
        return (
            'with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST they do: multicast is blocked (no '
            'network, firewall, container); allow it, name ROS_STATIC_PEERS, or set that'
        )
    return 'not with LOCALHOST either: is the loopback interface up (ip link set lo up)?'


def exchange(environment: Mapping[str, str], patience_s: float = PATIENCE_S) -> Times:
    """Start two processes and take their times.

    :param environment: what differs for them
    """
    topic = f'/bt_orchestrator_doctor/try_{uuid.uuid4().hex}'
    answering = _participant('answer', topic, patience_s, environment)
    asking = _participant('ask', topic, patience_s, environment)
    try:
        output, errors = asking.communicate(timeout=patience_s + START_S)
    except subprocess.TimeoutExpired:
        return Times(broken='a process that takes part never ends')
    finally:
        for process in (asking, answering):
            process.kill()
            process.communicate()
    if asking.returncode not in (0, NOTHING):
        lines = [line for line in errors.splitlines() if line.strip() and not line.startswith(' ')]
        return Times(broken=lines[-1] if lines else f'it ended with {asking.returncode}')
    return Times(*json.loads(output)) if output else Times()


def _participant(
    role: str, topic: str, patience_s: float, environment: Mapping[str, str]
) -> subprocess.Popen[str]:
    module = 'bt_orchestrator.ros.diagnosis.participant'
    return subprocess.Popen(
        [sys.executable, '-m', module, role, topic, str(patience_s)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, **environment},
        text=True,
    )


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
    discovery_s = asked = time.monotonic()
    while not heard:
        # Said again: the answer's way back may be known a moment later.
        publisher.publish(String(data='?'))
        if not spin():
            break
    times = [discovery_s - started, time.monotonic() - asked if heard else None]
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
