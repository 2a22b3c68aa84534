"""An answer that the middleware drops at first reaches a real client later."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from action_caller import ActionCaller
from rcl_interfaces.srv import GetParameters

from bt_orchestrator.ros.patient_service import create_patient_service

pytestmark = pytest.mark.every_distro


@pytest.fixture
def ros() -> Iterator[ActionCaller]:
    ros = ActionCaller()
    yield ros
    ros.close()


def test_a_dropped_answer_is_heard_later(
    ros: ActionCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[Any] = []
    plainly = rclpy.service.Service.send_response

    def drop_the_first(service: Any, response: Any, header: Any) -> None:
        sent.append(response)
        if len(sent) == 1:
            text = 'failed to send response (timeout): client will not receive response'
            warnings.warn(text, RuntimeWarning, stacklevel=1)
        else:
            plainly(service, response, header)

    monkeypatch.setattr(rclpy.service.Service, 'send_response', drop_the_first)
    create_patient_service(ros.node, GetParameters, '/ask', lambda request, response: response)
    client: Any = ros.node.create_client(GetParameters, '/ask')
    ros.spin_until(client.service_is_ready, 'the service')
    future = client.call_async(GetParameters.Request())
    ros.spin_until(future.done, 'the answer')
    assert future.result() == GetParameters.Response()
    assert len(sent) == 2
