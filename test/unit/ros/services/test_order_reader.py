"""Requests are read one after another, whatever becomes of the process that reads them."""

from __future__ import annotations

import pickle
import queue
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import LINE, cell

from bt_orchestrator.base.child_process import ChildFailed, ChildTooLate
from bt_orchestrator.base.errors import Finding, NotRead, Refused
from bt_orchestrator.base.replies import Reply, begin
from bt_orchestrator.engine.asking.orders import Told
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.limits import FINDINGS
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ros.services import order_reader
from bt_orchestrator.ros.services.order_reader import BUSY, LATE, MOST_WAITING, OrderReader
from bt_orchestrator.script.orders.desk import AskedOrder, OrderDesk, Orders
from bt_orchestrator.script.orders.desk_pickles import pickled

LONGEST_S = 40.0


class ProcessInHere:
    """Answers with a desk of this process, or fails as it is told to."""

    def __init__(self, desk: OrderDesk) -> None:
        self._desk = desk
        self.failures: list[Exception] = []
        self.may_answer = threading.Event()
        self.may_answer.set()
        self.asked = 0

    def ready(self) -> None:
        """It is."""

    def ask(self, data: bytes, within_s: float) -> bytes:
        self.asked += 1
        assert within_s > 0
        assert self.may_answer.wait(LONGEST_S)
        if self.failures:
            raise self.failures.pop(0)
        question = pickle.loads(data)
        return pickled(self._desk.answer(question), question.held)

    def close(self) -> None:
        """Nothing is left."""


class Bench:
    def __init__(self, folder: Path) -> None:
        (folder / 'test.yaml').write_text(LINE)
        desk = OrderDesk(cell(), FakeActionTypes(), [folder], any_path=False)
        self.process = ProcessInHere(desk)
        self.turns: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.reader = OrderReader(
            CellState(cell()),
            self.process,  # type: ignore[arg-type]
            self.turns.put,
        )
        self.said: list[str] = []

    def ask(self, order: str, script: str = 'test') -> None:
        begin(self._steps(order, script))

    async def _steps(self, order: str, script: str) -> None:
        try:
            async with self.reader.read(Orders((AskedOrder(script, order, 1),))) as reading:
                (read,) = reading.read
                self.said.append(read.id if isinstance(read, Job) else 'refused')
        except NotRead as why:
            self.said.append(str(why))

    def turn(self, times: int = 1) -> None:
        for _ in range(times):
            self.turns.get(timeout=LONGEST_S)()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    yield made
    made.reader.close()


def test_orders_keep_their_sequence_without_blocking(bench: Bench) -> None:
    bench.process.may_answer.clear()
    for name in ('A', 'B', 'C'):
        bench.ask(name)
    assert bench.said == []
    bench.process.may_answer.set()
    bench.turn(3)
    assert bench.said == ['A', 'B', 'C']


def test_ids_are_assigned_when_it_is_their_turn(bench: Bench) -> None:
    bench.ask('')
    bench.ask('WO-1', 'missing')
    bench.turn(2)
    assert bench.said == ['WO-1', 'refused']


def test_a_process_that_dies_is_asked_once_more(bench: Bench) -> None:
    bench.process.failures = [ChildFailed('the process ended by signal SIGKILL')]
    bench.ask('A')
    bench.turn()
    assert (bench.said, bench.process.asked) == (['A'], 2)


def test_reader_that_dies_twice_fails_only_its_order(bench: Bench) -> None:
    bench.process.failures = [ChildFailed('the process ended by signal SIGKILL')] * 2
    bench.ask('A')
    bench.ask('B')
    bench.turn(2)
    assert 'cannot be read now: the process ended by signal SIGKILL, twice' in bench.said[0]
    assert bench.said[1] == 'B'


def test_one_that_is_late_is_not_asked_again(bench: Bench) -> None:
    bench.process.failures = [ChildTooLate('no answer in time')]
    bench.ask('A')
    bench.turn()
    assert (bench.said, bench.process.asked) == ([LATE], 1)


def test_too_many_that_wait_are_told(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(order_reader, 'MOST_WAITING', 2)
    bench.process.may_answer.clear()
    for name in ('A', 'B', 'C', 'D'):
        bench.ask(name)
    assert bench.said == [BUSY]
    bench.process.may_answer.set()
    bench.turn(3)
    assert bench.said == [BUSY, 'A', 'B', 'C']


def test_exception_is_raised_at_caller_and_stops_nothing(bench: Bench) -> None:
    async def broken() -> None:
        with pytest.raises(RuntimeError, match='a defect'):
            async with bench.reader.read(Orders(())):
                raise RuntimeError('a defect')
        bench.said.append('broken')

    begin(broken())
    bench.ask('A')
    bench.turn(2)
    assert bench.said == ['broken', 'A']


def test_next_ids_are_assigned_once_these_are_recorded(bench: Bench) -> None:
    on_record: Reply[None] = Reply()

    async def slow() -> None:
        async with bench.reader.read(Orders((AskedOrder('test', '', 1),))) as reading:
            await on_record
            (read,) = reading.read
            assert isinstance(read, Job)
            bench.reader._state.order_ids.add(read.id)

    begin(slow())
    bench.ask('')
    bench.turn()
    assert bench.said == []
    on_record.give(None)
    bench.turn()
    assert bench.said == ['WO-2']


def test_many_simultaneous_ends_cause_no_deep_recursion(bench: Bench) -> None:
    def nothing() -> Orders:
        raise NotRead('not there')

    async def changed() -> None:
        with pytest.raises(NotRead, match='not there'):
            async with bench.reader.read(nothing):
                pytest.fail('nothing was read')
        bench.said.append('refused')

    bench.ask('A')
    for _ in range(MOST_WAITING):
        begin(changed())
    bench.turn()
    assert bench.said == ['A', *['refused'] * MOST_WAITING]


def test_omitted_findings_are_mentioned_once() -> None:
    reporter = Told()
    refused = Refused([Finding('x', 1, 1, 'wrong')] * 60)
    answers = [reporter.of(refused) for _ in range(200)]
    assert [len(answer) for answer in answers[:3]] == [60, FINDINGS - 60 + 1, 0]
    assert answers[1][-1].startswith('and 20 more; ')
    assert sum(map(len, answers)) == FINDINGS + 1
