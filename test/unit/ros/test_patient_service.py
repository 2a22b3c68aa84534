"""Answers that cannot be heard yet are sent again, and not for ever."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import pytest

from bt_orchestrator.replies import Reply
from bt_orchestrator.ros.patient_service import AGAIN_AFTER_S, PatientAnswers

TIMEOUT = 'failed to send response (timeout): client will not receive response'


class Bench:
    """A client that hears nothing at first, and a clock that is advanced by hand."""

    def __init__(self, deaf_times: int, words: str = TIMEOUT) -> None:
        self._deaf_times = deaf_times
        self._words = words
        self.sent: list[tuple[str, str]] = []
        self.delays: list[float] = []
        self.log: list[str] = []
        self._due: list[Callable[[], None]] = []
        self.answers = PatientAnswers('/ask', self._send, self._later, self)

    def warning(self, message: str) -> None:
        self.log.append(message)

    def run(self) -> None:
        while self._due:
            self._due.pop(0)()

    def _send(self, response: str, header: str) -> None:
        self.sent.append((response, header))
        if len(self.sent) <= self._deaf_times:
            warnings.warn(self._words, RuntimeWarning, stacklevel=1)

    def _later(self, delay_s: float, callback: Callable[[], None]) -> None:
        self.delays.append(delay_s)
        self._due.append(callback)


@pytest.mark.parametrize('deaf_times', [0, 1, len(AGAIN_AFTER_S)])
def test_it_is_sent_until_it_is_heard(deaf_times: int) -> None:
    bench = Bench(deaf_times)
    bench.answers.send('yes', 'client 1')
    bench.run()
    assert bench.sent == [('yes', 'client 1')] * (deaf_times + 1)
    assert bench.delays == list(AGAIN_AFTER_S[:deaf_times])
    assert bench.log == []


def test_a_client_that_is_gone_is_given_up() -> None:
    bench = Bench(deaf_times=99)
    bench.answers.send('yes', 'client 1')
    bench.run()
    assert len(bench.sent) == 1 + len(AGAIN_AFTER_S)
    assert bench.log == ['an answer of /ask was not heard: its client is gone, or not discovered']


def test_other_warnings_are_handed_on_and_nothing_is_sent_again() -> None:
    bench = Bench(deaf_times=1, words='something else')
    with pytest.warns(RuntimeWarning, match='something else'):
        bench.answers.send('yes', 'client 1')
    bench.run()
    assert len(bench.sent) == 1


def test_an_answer_that_is_not_there_yet_is_sent_when_it_is() -> None:
    bench = Bench(deaf_times=1)
    later, at_once = Reply[str](), Reply[str]()
    at_once.give('no')
    bench.answers.send(later, 'client 1')
    bench.answers.send(at_once, 'client 2')
    assert bench.sent == [('no', 'client 2')]
    bench.run()
    later.give('yes')
    assert bench.sent == [('no', 'client 2')] * 2 + [('yes', 'client 1')]
