"""How long the quickest of some answers took that nobody heard, in a process of its own.

    python test/unheard_answers.py

A client that wants another QoS stands for one that has left after it asked. Fast DDS reads its
profiles when the first participant of a process is made.
"""

from __future__ import annotations

import os
import time
import warnings
from typing import Any

from action_caller import ActionCaller
from rcl_interfaces.srv import GetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile

from bt_orchestrator.ros.services.prompt_profile import prompt_answers

TRIES = 20


def main() -> None:
    """Print the seconds."""
    with prompt_answers(os.environ):
        ros = ActionCaller()
    took_s: list[float] = []
    service: Any = ros.node.create_service(GetParameters, '/ask', lambda asked, response: response)
    plainly = service.send_response

    def send(response: Any, header: Any) -> None:
        began = time.monotonic()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter('always')
            plainly(response, header)
        assert caught, 'somebody heard it'
        took_s.append(time.monotonic() - began)

    service.send_response = send
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    deaf: Any = ros.node.create_client(GetParameters, '/ask', qos_profile=latched)

    def are_enough() -> bool:
        deaf.call_async(GetParameters.Request())
        return len(took_s) >= TRIES

    ros.spin_until(are_enough, 'answers that nobody hears')
    print(min(took_s))  # noqa: T201 - for the parent process
    ros.close()


if __name__ == '__main__':
    main()
