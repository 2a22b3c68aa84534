"""`~/get_events` tells much, and never so much that its answer keeps the node."""

from __future__ import annotations

from collections.abc import Callable
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

from bt_orchestrator_interfaces.srv import GetEvents

from bt_orchestrator.engine.runtime.writers import Readings
from bt_orchestrator.model.events import JobStarted
from bt_orchestrator.model.limits import EVENTS_BYTES
from bt_orchestrator.ros.services.reading_services import EventsService
from bt_orchestrator.store.memory import MemoryStore

LONG = 400_000

IN_TIME_S = 30.0


class ServiceHost:
    """What of a node the service needs, and the service."""

    answer: Callable[[Any, Any], Any]
    service_name = 'get_events'

    def send_response(self, response: Any, header: Any) -> None:
        """Do nothing: here the answer is taken from the callback."""

    def get_logger(self) -> None:
        """Return nothing, which nobody asks here."""

    def create_service(
        self, kind: Any, name: str, answer: Callable[[Any, Any], Any], **options: Any
    ) -> ServiceHost:
        self.answer = answer
        return self


def asked(lengths: list[int], **request: int) -> list[int]:
    """Return the numbers of the events that are told of such a journal."""
    store, host = MemoryStore('here'), ServiceHost()
    store.append([JobStarted(seq=n, job='j' * size) for n, size in enumerate(lengths, 1)])
    orchestrator = SimpleNamespace(kept_seq=len(lengths))
    turns: SimpleQueue[Callable[[], None]] = SimpleQueue()
    readings = Readings(turns.put)
    EventsService(host, orchestrator, store, readings)  # type: ignore[arg-type]
    answer = host.answer(GetEvents.Request(**request), GetEvents.Response())
    turns.get(timeout=IN_TIME_S)()
    assert readings.close(IN_TIME_S)
    response = answer.value
    assert response.accepted
    return [event.seq for event in response.events]


def test_an_answer_is_no_longer_than_its_limit() -> None:
    assert asked([LONG] * 10) == [1, 2]
    assert asked([LONG] * 10, after_seq=7) == [8, 9]
    assert asked([10] * 10) == list(range(1, 11))


def test_one_event_is_told_however_long() -> None:
    assert asked([2 * EVENTS_BYTES] * 3, after_seq=1) == [2]
