"""Answers of services, as the middleware hands them out."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace
from typing import Any

import pytest

from bt_orchestrator.ros.executor import lean_parts
from bt_orchestrator.ros.executor.lean_parts import LeanQuestions
from bt_orchestrator.ros.executor.ways import Service


class Handle:
    """A service client that counts how often it is asked for an answer."""

    def __init__(self) -> None:
        self.answers: deque[int] = deque()
        self.asked = 0
        self._sent = 0

    def __enter__(self) -> None:
        """Nothing destroys it."""

    def __exit__(self, *_: object) -> None:
        """Nothing destroys it."""

    def send_request(self, _: object) -> int:
        self._sent += 1
        return self._sent

    def take_response(self, _: object) -> tuple[Any, Any]:
        self.asked += 1
        if not self.answers:
            return None, None
        number = self.answers.popleft()
        header = SimpleNamespace(request_id=SimpleNamespace(sequence_number=number))
        return header, f'answer {number}'


@pytest.fixture
def handle(monkeypatch: pytest.MonkeyPatch) -> Handle:
    fake = Handle()
    monkeypatch.setattr(lean_parts, '_client', lambda *_: fake)
    return fake


def make() -> LeanQuestions:
    service = Service(SimpleNamespace(Response=object), 'name')
    node: Any = SimpleNamespace(handle=None, resolve_service_name=str)
    return LeanQuestions(node, service)


def told(service: LeanQuestions) -> list[str]:
    heard: list[str] = []
    for call, message in service.take():
        call(message)
        heard.append(message)
    return heard


def test_taking_stops_after_last_awaited_answer(handle: Handle) -> None:
    service = make()
    service.ask('one', lambda _: None)
    handle.answers.append(1)
    assert told(service) == ['answer 1']
    assert handle.asked == 1


def test_all_ready_awaited_answers_are_taken_at_once(handle: Handle) -> None:
    service = make()
    for question in ('one', 'two', 'three'):
        service.ask(question, lambda _: None)
    handle.answers.extend([1, 2])
    assert told(service) == ['answer 1', 'answer 2']


def test_unawaited_answers_are_dropped_one_by_one(handle: Handle) -> None:
    service = make()
    handle.answers.extend([service._send('cancel'), service._send('cancel again')])
    assert (told(service), len(handle.answers)) == ([], 1)
    assert (told(service), len(handle.answers)) == ([], 0)
