"""Answers that cannot be heard yet are sent again, and not for ever."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable

import pytest

from bt_orchestrator.base.replies import Reply
from bt_orchestrator.model.limits import UNHEARD_S, UNHEARD_TOGETHER_S
from bt_orchestrator.ros.services.patient_service import (
    AGAIN_AFTER_S,
    MOST_HELD,
    PAUSE,
    SUSPECT_S,
    PatientAnswers,
    Turns,
)

UNHEARD = (
    'an answer of /ask was not heard: its client is gone, not discovered, or wants another QoS'
)
TIMEOUT_S = 0.1
PROMPT_S = 0.001
"""The same where the middleware waits for nobody."""
TURN_S = 1e-6
"""What is asked for at once comes in the next turn of the executor."""
PAUSED_S = PAUSE * TIMEOUT_S + 1e-9
"""A pause, and the error of adding it to a time."""
TIMEOUT = 'failed to send response (timeout): client will not receive response'


class Bench:
    """A client that hears nothing at first, and a clock that is advanced by hand."""

    def __init__(
        self, deaf_times: int, words: str = TIMEOUT, timeout_s: float = TIMEOUT_S
    ) -> None:
        self._deaf_times = deaf_times
        self._words = words
        self._timeout_s = timeout_s
        self.sent: list[tuple[str, str]] = []
        self.delays: list[float] = []
        self.log: list[str] = []
        self.now = 0.0
        self.kept_s = 0.0
        """How long the thread was kept by answers that nobody heard."""
        self._deaf: set[str] = set()
        self._due: list[tuple[float, Callable[[], None]]] = []
        self._turns = Turns(self._later)
        self.longest_s = 0.0
        """How long the thread was kept at most, between two times at which others had theirs."""
        self._others_at = 0.0
        self.answers = self.service('/ask')

    def service(self, name: str) -> PatientAnswers:
        """Return the answers of a service more."""
        return PatientAnswers(name, self._send, self._turns, self, lambda: self.now)

    def warning(self, message: str) -> None:
        self.log.append(message)

    def run(self) -> None:
        """Let the time run until nothing is left to be done."""
        self.run_until(math.inf)

    def run_until(self, end: float) -> None:
        """Let the time run."""
        while self._due and min(self._due, key=_time)[0] <= end:
            due = min(self._due, key=_time)
            self._due.remove(due)
            if due[0] > self.now:  # only then the thread is free
                self.now = self._others_at = due[0]
            due[1]()
        if self.now < end < math.inf:
            self.now = self._others_at = end

    def deafen(self, client: str) -> None:
        """Let a client hear nothing any more."""
        self._deaf.add(client)

    def _send(self, response: str, header: str) -> None:
        self.sent.append((response, header))
        if len(self.sent) <= self._deaf_times or header in self._deaf:
            self.now += self._timeout_s
            self.kept_s += self._timeout_s
            self.longest_s = max(self.longest_s, self.now - self._others_at)
            warnings.warn(self._words, RuntimeWarning, stacklevel=1)

    def _later(self, delay_s: float, callback: Callable[[], None]) -> None:
        self.delays.append(delay_s)
        self._due.append((self.now + max(delay_s, TURN_S), callback))


def _time(due: tuple[float, Callable[[], None]]) -> float:
    return due[0]


@pytest.mark.parametrize('deaf_times', [0, 1, len(AGAIN_AFTER_S)])
def test_it_is_sent_until_it_is_heard(deaf_times: int) -> None:
    bench = Bench(deaf_times)
    bench.answers.send('yes', 'client 1')
    bench.run()
    assert bench.sent == [('yes', 'client 1')] * (deaf_times + 1)
    again = [delay for delay in bench.delays if delay != pytest.approx(PAUSED_S)]
    assert again == list(AGAIN_AFTER_S[:deaf_times])
    assert bench.log == []


def test_a_client_that_is_gone_is_given_up() -> None:
    bench = Bench(deaf_times=99)
    bench.answers.send('yes', 'client 1')
    bench.run()
    assert len(bench.sent) == 1 + len(AGAIN_AFTER_S)
    assert bench.log == [UNHEARD]


def test_other_warnings_pass_and_nothing_is_resent() -> None:
    bench = Bench(deaf_times=1, words='something else')
    with pytest.warns(RuntimeWarning, match='something else'):
        bench.answers.send('yes', 'client 1')
    bench.run()
    assert len(bench.sent) == 1


def test_pending_answer_is_sent_once_available() -> None:
    bench = Bench(deaf_times=1)
    later, at_once = Reply[str](), Reply[str]()
    at_once.give('no')
    bench.answers.send(later, 'client 1')
    bench.answers.send(at_once, 'client 2')
    assert bench.sent == [('no', 'client 2')]
    bench.run()
    later.give('yes')
    assert bench.sent == [('no', 'client 2')] * 2 + [('yes', 'client 1')]


@pytest.mark.parametrize('every_s', [1.0, 0.1])
def test_deaf_client_takes_little_thread_time(
    every_s: float,
) -> None:
    bench, seconds = Bench(deaf_times=0), 100
    bench.deafen('client 1')
    for turn in range(round(seconds / every_s)):
        bench.run_until(turn * every_s)
        bench.answers.send(f'{turn}', 'client 1')
    assert bench.kept_s <= UNHEARD_S.at_once + seconds * UNHEARD_S.per_s + TIMEOUT_S
    assert UNHEARD in bench.log


def test_deaf_clients_block_thread_for_one_answer() -> None:
    bench, clients = Bench(deaf_times=0), 10
    services = [bench.service(f'/{number}') for number in range(3)]
    for number in range(clients):
        bench.deafen(f'client {number}')
        for service in services:
            service.send('no', f'client {number}')
    bench.run()
    assert len(bench.sent) > len(services) * clients  # some of them were sent again, together
    assert bench.longest_s == pytest.approx(TIMEOUT_S)


def test_many_services_share_limit_of_blocked_time() -> None:
    bench, seconds = Bench(deaf_times=0), 200
    services = [bench.service(f'/{number}') for number in range(20)]
    bench.deafen('client 1')
    for turn in range(seconds):
        bench.run_until(turn)
        for service in services:
            service.send(f'{turn}', 'client 1')
    first_of_each_s = len(services) * TIMEOUT_S * (1 + seconds / SUSPECT_S)
    together_s = UNHEARD_TOGETHER_S.at_once + seconds * UNHEARD_TOGETHER_S.per_s
    assert bench.kept_s <= together_s + first_of_each_s


def test_deaf_clients_do_not_delay_another_service() -> None:
    bench = Bench(deaf_times=0)
    deaf, well = bench.service('/deaf'), bench.service('/well')
    bench.deafen('client 1')
    for turn in range(100):
        bench.run_until(float(turn))
        for _ in range(10):
            deaf.send(f'{turn}', 'client 1')
        well.send(f'{turn}', 'client 2')
        bench.run_until(bench.now + TIMEOUT_S + 2 * PAUSED_S)
        assert (f'{turn}', 'client 2') in bench.sent


def test_prompt_middleware_gets_one_try_per_turn() -> None:
    bench, many = Bench(deaf_times=0, timeout_s=PROMPT_S), MOST_HELD
    other = bench.service('/other')
    bench.deafen('client 1')
    for turn in range(many):
        bench.answers.send(f'{turn}', 'client 1')
        other.send(f'{turn}', 'client 2')
        assert bench.sent[-1] == (f'{turn}', 'client 2'), 'others wait for no pause'
    bench.run()
    assert bench.longest_s == pytest.approx(PROMPT_S)
    assert len([1 for _, client in bench.sent if client == 'client 1']) > many


def test_others_are_answered_soon_beside_deaf_client() -> None:
    bench = Bench(deaf_times=0)
    bench.deafen('client 1')
    for turn in range(100):
        bench.run_until(2.0 * turn)
        bench.answers.send(f'{turn}', 'client 1')
        bench.answers.send(f'{turn}', 'client 2')
        bench.run_until(bench.now + PAUSED_S)
        assert bench.sent[-1] == (f'{turn}', 'client 2')
    bench.run()
    assert len([1 for _, client in bench.sent if client == 'client 2']) == 100


def test_waiting_answers_keep_order_and_are_limited() -> None:
    bench = Bench(deaf_times=0)
    bench.deafen('client 1')
    for turn in range(round(2 * UNHEARD_S.at_once / TIMEOUT_S)):
        bench.answers.send(f'{turn}', 'client 1')
    bench.answers.send('first', 'client 2')
    bench.answers.send('second', 'client 2')
    assert bench.sent[-1][1] == 'client 1'
    bench.run()
    assert [answer for answer, client in bench.sent if client == 'client 2'] == ['first', 'second']

    for turn in range(2 * MOST_HELD):
        bench.answers.send(f'{turn}', 'client 1')
    assert any('was dropped: too many wait' in line for line in bench.log)
