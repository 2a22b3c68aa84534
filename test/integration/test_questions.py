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
    one = Handle()
    monkeypatch.setattr(lean_parts, '_client', lambda *_: one)
    return one


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


def test_the_last_answer_that_is_awaited_is_the_last_one_that_is_taken(handle: Handle) -> None:
    service = make()
    service.ask('one', lambda _: None)
    handle.answers.append(1)
    assert told(service) == ['answer 1']
    assert handle.asked == 1


def test_all_that_is_awaited_and_there_is_taken_at_once(handle: Handle) -> None:
    service = make()
    for question in ('one', 'two', 'three'):
        service.ask(question, lambda _: None)
    handle.answers.extend([1, 2])
    assert told(service) == ['answer 1', 'answer 2']


def test_what_nobody_awaits_goes_one_by_one_and_is_told_to_nobody(handle: Handle) -> None:
    service = make()
    handle.answers.extend([service._send('cancel'), service._send('cancel again')])
    assert (told(service), len(handle.answers)) == ([], 1)
    assert (told(service), len(handle.answers)) == ([], 0)
