"""Every request is answered, and every answer comes, whatever the middleware drops by default."""

from __future__ import annotations

import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from action_caller import ActionCaller
from rcl_interfaces.srv import GetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile

from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.ros.qos import create_client
from bt_orchestrator.ros.services import patient_service
from bt_orchestrator.ros.services.patient_service import create_patient_service, make_all_patient

pytestmark = pytest.mark.every_distro

MANY = 60
"""Requests that wait at a time; by default ROS 2 keeps 10 and drops the others without a word."""

UNHEARD = Path(__file__).parents[1] / 'unheard_answers.py'
MOST_S = 0.05
"""Of the quickest of many: half of what each takes by default, however busy the machine is."""

ASK_EVERY_S = 0.2
"""More requests than that wait, and are dropped, before the first one is given up."""


@pytest.fixture
def ros() -> Iterator[ActionCaller]:
    ros = ActionCaller()
    yield ros
    ros.close()


@pytest.fixture
def elsewhere() -> Iterator[ActionCaller]:
    elsewhere = ActionCaller()
    yield elsewhere
    elsewhere.close()


def serve_and_find(
    serving: ActionCaller,
    *asking: ActionCaller,
    answer: Callable[[Any, Any], Any] = lambda request, response: response,
) -> list[Any]:
    """Offer `/ask`, and return a client for each of those that ask."""
    create_patient_service(serving.node, GetParameters, '/ask', answer)
    clients: list[Any] = [create_client(caller.node, GetParameters, '/ask') for caller in asking]
    for client in clients:
        serving.spin_until(client.service_is_ready, 'the service')
    return clients


def all_answered(futures: list[Any]) -> bool:
    return all(future.done() for future in futures)


def drop_the_first(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Have the first answer of this process dropped; return all that are sent."""
    sent: list[Any] = []
    plainly = rclpy.service.Service.send_response

    def send(service: Any, response: Any, header: Any) -> None:
        sent.append(response)
        if len(sent) == 1:
            text = 'failed to send response (timeout): client will not receive response'
            warnings.warn(text, RuntimeWarning, stacklevel=1)
        else:
            plainly(service, response, header)

    monkeypatch.setattr(rclpy.service.Service, 'send_response', send)
    return sent


def test_a_dropped_answer_is_heard_later(
    ros: ActionCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent = drop_the_first(monkeypatch)
    create_patient_service(ros.node, GetParameters, '/ask', lambda request, response: response)
    client: Any = ros.node.create_client(GetParameters, '/ask')
    ros.spin_until(client.service_is_ready, 'the service')
    future = client.call_async(GetParameters.Request())
    ros.spin_until(future.done, 'the answer')
    assert future.result() == GetParameters.Response()
    assert len(sent) == 2


def test_the_services_for_parameters_are_patient_too(
    ros: ActionCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = drop_the_first(monkeypatch)
    make_all_patient(ros.node)
    service = f'{ros.node.get_fully_qualified_name()}/get_parameters'
    client: Any = ros.node.create_client(GetParameters, service)
    ros.spin_until(client.service_is_ready, 'the service')
    ros.wait(client.call_async(GetParameters.Request(names=['use_sim_time'])), 'the answer')
    assert len(tried) == 2


def test_unheard_answer_blocks_thread_only_briefly() -> None:
    quickest = subprocess.run(
        [sys.executable, str(UNHEARD)], capture_output=True, text=True, check=True
    )
    assert float(quickest.stdout) < MOST_S, 'the middleware waits for who does not hear'


def test_requests_that_came_at_once_are_all_answered(ros: ActionCaller) -> None:
    (client,) = serve_and_find(ros, ros)
    futures = [client.call_async(GetParameters.Request()) for _ in range(MANY)]
    ros.spin_until(lambda: all_answered(futures), 'all answers')


def test_answers_to_others_displace_no_pending_answer(
    ros: ActionCaller, elsewhere: ActionCaller
) -> None:
    asked: list[Any] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request)
        return response

    talkative, busy = serve_and_find(ros, ros, elsewhere, answer=answer)
    waits = busy.call_async(GetParameters.Request())
    ros.spin_until(lambda: asked, 'the first request')
    for _ in range(MANY):
        ros.wait(talkative.call_async(GetParameters.Request()), 'an answer')
    assert not waits.done(), 'it was busy all the time'
    elsewhere.wait(waits, 'the answer that came before those to the other one')


def test_answer_lost_to_qos_mismatch_is_logged(
    ros: ActionCaller, elsewhere: ActionCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[str] = []
    monkeypatch.setattr(patient_service, 'AGAIN_AFTER_S', (0.1,))
    monkeypatch.setattr(SpareLog, 'warning', lambda log, line: lines.append(line))
    (client,) = serve_and_find(ros, ros)
    ros.wait(client.call_async(GetParameters.Request()), 'an answer')
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    deaf: Any = elsewhere.node.create_client(GetParameters, '/ask', qos_profile=latched)
    asked: list[Any] = []

    def is_told() -> bool:  # it is never ready, so that it asks until the service hears it
        if time.monotonic() > began + ASK_EVERY_S * len(asked):
            asked.append(deaf.call_async(GetParameters.Request()))
        return bool(lines)

    began = time.monotonic()
    ros.spin_until(is_told, 'a line in the log')
    assert 'wants another QoS' in lines[0]
    assert not elsewhere.spin_for(0.1, lambda: any(future.done() for future in asked))
    ros.wait(client.call_async(GetParameters.Request()), 'an answer to who hears')
