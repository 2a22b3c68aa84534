"""Commands without end, and texts without end: the journal stays small, the line goes on (7.1)."""

from __future__ import annotations

import itertools
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.calls import calls
from fakes.commands import (
    Abort,
    AnswerHold,
    ControlJob,
    MoveJob,
    Pause,
    RemoveItem,
    Resume,
    Stop,
)
from fakes.line import THREE, Line
from fakes.operator import engineer

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import to_record, to_text
from bt_orchestrator.model.commands import Answer, Command, FoundTwin, RefusedRequest, Shutdown
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.limits import COMMANDS_OF_ONE, REFUSALS_OF_ONE
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.store.sqlite.store import SqliteStore

TYPES = FakeActionTypes()

LONG = 'x' * 5_000_000

A_MINUTE_OF_REFUSALS = 200_000
"""Bytes on the disk that refusals may take in a minute, however many there are."""


class Cell:
    """An engine with its journal on disk, and a clock that moves when a test says so."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.line = Line()
        self.clock = VirtualClock(1_700_000_000.0)
        self.store = SqliteStore(folder / 'journal.sqlite3', synchronous='NORMAL')
        gateway = VirtualGateway(self.line.cell, TYPES, self.clock)
        self.orchestrator = Orchestrator(
            self.line.cell, gateway, self.clock, self.store, auto_start=False
        )
        self.orchestrator.settle()

    def ask(self, command: Command) -> Answer:
        return self.orchestrator.ask(command)

    def order(self, name: str, by: By) -> Answer:
        return self.ask(AddJobs((Job(name, self.line.script(THREE), 1),), by))

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        over = self.clock.call_at(self.clock.now() + seconds, lambda: None)
        until = self.clock.now() + seconds
        while self.clock.now() < until and self.clock.advance():
            self.orchestrator.settle()
        over.cancel()

    @property
    def bytes(self) -> int:
        """What the journal takes on the disk, its log emptied: that one is used again."""
        with closing(sqlite3.connect(self.folder / 'journal.sqlite3')) as connection:
            connection.execute('PRAGMA wal_checkpoint(TRUNCATE)')
        return sum(file.stat().st_size for file in self.folder.iterdir())

    @property
    def records(self) -> list[dict[str, Any]]:
        return [to_record(event) for event in self.store.read()]

    def of(self, event: str) -> list[dict[str, Any]]:
        return [record for record in self.records if record['event'] == event]


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[Cell]:
    instance = Cell(tmp_path)
    yield instance
    instance.orchestrator.close()
    instance.store.close()


def by(who: str = 'Eve', reason: str = 'no reason', origin: str = 'a flood') -> By:
    return engineer(who, origin, reason)


@pytest.mark.parametrize('command', [Abort, Pause])
def test_endless_text_is_refused_at_low_cost(cell: Cell, command: Callable[[By], Command]) -> None:
    """Counted in calls, which are the same on every machine: nothing goes through it."""
    needed = calls(lambda: cell.ask(command(by(reason='\N{SNOWMAN}\x1b' * 2_500_000))))
    assert needed < 20_000
    (refused,) = cell.of('operator.refused')
    assert '\x1b' not in refused['reason']
    assert refused['reason'].endswith('(5000000 characters, the rest is cut)')


@pytest.mark.parametrize(
    ('command', 'message'),
    [
        (Pause(by(reason=LONG)), 'reason has 5000000 characters; expected at most 2000'),
        (Pause(by(who=LONG)), 'who has 5000000 characters; expected at most 200'),
        (Pause(by(origin=LONG)), 'origin has 5000000 characters; expected at most 200'),
        (AnswerHold(LONG, 'retry', by()), 'hold has 5000000 characters; expected at most 200'),
        (RemoveItem(LONG, by()), 'item has 5000000 characters; expected at most 200'),
        (ControlJob('hold', LONG, by()), 'job has 5000000 characters; expected at most 200'),
        (MoveJob(LONG, 1, by()), 'job has 5000000 characters; expected at most 200'),
        (RefusedRequest(LONG, by(reason=LONG), LONG, (LONG,)), ''),
    ],
    ids=lambda value: type(value).__name__,
)
def test_7_1_long_text_is_refused_and_cut_on_record(
    cell: Cell, command: Command, message: str
) -> None:
    before = cell.bytes
    answer = cell.ask(command)
    assert not answer.accepted
    assert answer.message.startswith(message)
    (refused,) = cell.of('operator.refused')
    assert max(len(value) for value in refused.values() if isinstance(value, str)) <= 2000
    assert cell.bytes - before < 40_000


def test_7_1_refusals_with_long_reasons_keep_journal_small(cell: Cell) -> None:
    before = cell.bytes
    for _ in range(40):
        assert not cell.ask(Stop(by(reason=LONG))).accepted
    assert cell.bytes - before < A_MINUTE_OF_REFUSALS


def test_7_1_ticket_in_origin_makes_no_new_sender(cell: Cell) -> None:
    for number in range(300):
        assert not cell.ask(Stop(by(reason=LONG, origin=f'page {number:016x}'))).accepted
    written = sum(
        len(to_text(event)) for event in cell.store.read() if event.event == 'operator.refused'
    )
    assert written <= REFUSALS_OF_ONE.at_once
    cell.wait(61)
    (counted,) = cell.of('request.refused')
    assert (counted['who'], counted['origin']) == ('Eve', 'page')


def new_names() -> Callable[[], By]:
    numbers = itertools.count()
    return lambda: by(f'Eve {next(numbers)}')


@pytest.mark.parametrize('sender', [by, new_names()], ids=['one name', 'a new name each time'])
def test_7_1_refusals_write_limited_bytes_per_minute(cell: Cell, sender: Callable[[], By]) -> None:
    for _ in range(3):
        before = cell.bytes
        for _ in range(3000):
            assert not cell.ask(ControlJob('hold', 'nobody', sender())).accepted
            assert not cell.ask(AnswerHold('7', 'retry', sender())).accepted
        cell.wait(60.0)
        assert cell.bytes - before < A_MINUTE_OF_REFUSALS
        assert len(cell.of('request.refused')) <= 6 * 3
    singly, many = cell.of('operator.refused'), cell.of('request.refused')
    assert 20 < len(singly) < 500
    counted = sum((Counter(record['commands']) for record in many), Counter())
    assert len(singly) + sum(record['count'] for record in many) == 3 * 6000
    counted.update(record['command'] for record in singly)
    assert counted == {'hold': 9000, 'retry': 9000}


def test_7_1_what_is_counted_is_told_after_a_minute(cell: Cell) -> None:
    for _ in range(100):
        cell.ask(ControlJob('hold', 'nobody', by()))
    began = cell.clock.now()
    assert not cell.of('request.refused')
    cell.wait(59.0)
    assert not cell.of('request.refused')
    cell.wait(1.0)
    (many,) = cell.of('request.refused')
    singly = len(cell.of('operator.refused'))
    assert many == {
        'seq': cell.orchestrator.state.seq,
        'time': began + 60.0,
        'event': 'request.refused',
        'who': 'Eve',
        'origin': 'a flood',
        'count': 100 - singly,
        'since': began,
        'commands': {'hold': 100 - singly},
        'message': 'there is no job nobody; jobs now: none',
    }


def test_7_1_counted_refusals_are_recorded_before_shutdown(cell: Cell) -> None:
    for _ in range(100):
        cell.ask(ControlJob('hold', 'nobody', by()))
    cell.ask(Shutdown())
    assert [record['event'] for record in cell.records][-2:] == [
        'request.refused',
        'orchestrator.stopping',
    ]


def test_7_1_flood_keeps_other_senders_recorded_singly(cell: Cell) -> None:
    for _ in range(1000):
        cell.ask(ControlJob('hold', 'nobody', by()))
    cell.ask(ControlJob('hold', 'nothing', by('Ann')))
    assert [record['who'] for record in cell.of('operator.refused')][-1] == 'Ann'


# --- commands that are carried out ------------------------------------------------------------


def test_7_1_ten_thousand_orders_stay_within_sender_limit(
    cell: Cell,
) -> None:
    for number in range(100):
        assert cell.order(f'WO-{number}', by('MES', 'the plan of the week')).accepted
    written = sum(
        len(to_text(event)) for event in cell.store.read() if event.event != 'script.loaded'
    )
    assert 100 * written < COMMANDS_OF_ONE.at_once / 2


def test_7_1_endless_pause_and_resume_fill_no_disk(cell: Cell) -> None:
    before = cell.bytes
    reason = 'x' * 2000
    accepted = 0
    for _ in range(10_000):
        assert cell.ask(Pause(by(reason=reason))).accepted
        answer = cell.ask(Resume(by(reason=reason)))
        if not answer.accepted:
            break
        accepted += 1
    assert answer.message.startswith('too many commands: Eve, or all senders together,')
    assert accepted > 1000
    assert cell.bytes - before < 64_000_000
    held = cell.bytes
    (pause,) = cell.orchestrator.state.holds
    remark = cell.ask(AnswerHold(pause, 'comment', by(reason=reason)))
    assert remark.message.startswith('too many commands')
    for _ in range(1000):
        cell.ask(Resume(by(reason=reason)))
    cell.wait(60.0)
    assert cell.bytes - held < 500_000
    cell.wait(600.0)
    assert cell.ask(Resume(by())).accepted


def test_7_1_others_are_heard_while_one_sends_too_much(cell: Cell) -> None:
    while cell.ask(Resume(by(reason='x' * 2000))).accepted or cell.of('hold.raised') == []:
        cell.ask(Pause(by(reason='x' * 2000)))
    assert cell.ask(Resume(by('Ann'), everyones=True)).accepted


def test_7_1_what_stops_is_taken_at_any_time(cell: Cell) -> None:
    cell.order('J', by())
    for _ in range(10_000):
        cell.ask(Pause(by(reason='x' * 2000)))
        if not cell.ask(Resume(by(reason='x' * 2000))).accepted:
            break
    assert cell.ask(Abort(by())).accepted


def test_7_3_a_limited_number_of_pauses_stands(cell: Cell) -> None:
    answers = [cell.ask(Pause(by(f'Eve {number}'))) for number in range(40)]
    assert [answer.accepted for answer in answers] == [True] * 32 + [False] * 8
    assert answers[-1].message.startswith('32 pauses stand already')
    assert cell.ask(Resume(by(), everyones=True)).accepted
    assert cell.ask(Pause(by())).accepted


def test_7_3_a_limited_number_of_twins_is_told(cell: Cell) -> None:
    for number in range(100):
        cell.ask(FoundTwin(f'process {number}'))
    assert len(cell.orchestrator.state.pauses) == 8
