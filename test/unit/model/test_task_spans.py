"""The start of an attempt finds its end."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.task_spans import TaskSpans

WORK = {'job': 'J', 'section': 2, 'item': 'J/1', 'task': 'work'}


def started(time: float, attempt: int = 1, **where: object) -> e.TaskStarted:
    place = {**WORK, **where}
    return e.TaskStarted(
        **place,  # type: ignore[arg-type]
        name='TASK_A',
        action='/a2/do',
        component='a2',
        attempt=attempt,
        goal=str(attempt),
        time=time,
    )


def failed(time: float, attempt: int = 1) -> e.TaskFailed:
    return e.TaskFailed(**WORK, attempt=attempt, reason='aborted', time=time)  # type: ignore[arg-type]


def succeeded(time: float, attempt: int = 1) -> e.TaskSucceeded:
    return e.TaskSucceeded(**WORK, attempt=attempt, goal='', time=time)  # type: ignore[arg-type]


def test_every_attempt_is_a_span_of_its_own() -> None:
    spans = TaskSpans()
    events = [started(1.0), failed(2.5), started(3.0, 2), succeeded(7.0, 2)]
    closed_spans = [span for span in map(spans.follow, events) if span is not None]
    assert closed_spans == [(events[0], events[1]), (events[2], events[3])]
    assert [span.seconds for span in closed_spans] == [1.5, 4.0]


def test_same_task_of_two_items_has_two_spans() -> None:
    spans = TaskSpans()
    other = started(2.0, item='J/2')
    assert spans.follow(started(1.0)) is None
    assert spans.follow(other) is None
    assert list(spans.open()) == [started(1.0), other]
    assert spans.start_of(other) == other
    assert spans.follow(succeeded(3.0)) == (started(1.0), succeeded(3.0))
    assert list(spans.open()) == [other]


def test_task_that_fails_unsent_has_no_span() -> None:
    assert TaskSpans().follow(failed(1.0)) is None


def test_what_is_forgotten_finds_no_end() -> None:
    spans = TaskSpans()
    spans.follow(started(1.0))
    spans.forget()
    assert spans.follow(succeeded(2.0)) is None
