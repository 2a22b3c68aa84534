"""Leader and standby: two nodes, one database, controllers in other processes (semantics 9.4)."""

from __future__ import annotations

import os
import random
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator
from socket import gethostname

import pytest
from cell_processes import SMALL_CELL, CellProcesses, StartCell, remembering
from diagnostic_msgs.msg import DiagnosticArray
from postgres_server import PostgresServer, kept_events
from program_process import ProgramProcess

from bt_orchestrator.model import events as e

ITEMS = 6


class Pair:
    """Two nodes of one cell: the one that leads is the node of `cell`."""

    def __init__(self, cell: CellProcesses) -> None:
        self.cell = cell
        self._started = 0
        self.others: list[ProgramProcess] = []
        """Standbys, and leaders of before."""

    @property
    def leader(self) -> ProgramProcess:
        return self.cell.node

    def start_standby(self) -> ProgramProcess:
        """Start a standby and wait until it is ready to take over."""
        self._started += 1
        standby = self.cell.start_beside(f'standby_{self._started}')
        self.others.append(standby)
        standby.wait_ready('standby ready: ')
        return standby

    def lead(self, standby: ProgramProcess, within_s: float = 20.0) -> float:
        """Wait until a standby has taken over; return how long that took."""
        began = time.monotonic()
        self.until(lambda: 'tree node ready: ' in standby.output, 'a take-over', within_s)
        self.others.remove(standby)
        self.others.append(self.cell.node)
        self.cell.node = standby
        return time.monotonic() - began

    def until(self, is_so: Callable[[], object], what: str, within_s: float = 60.0) -> None:
        assert self.cell.watch.ros.spin_for(within_s, is_so), f'waited {within_s:g} s for {what}'

    def until_goals(self, number: int) -> None:
        """Wait until so many goals have been started at the controllers."""
        self.until(lambda: len(self.cell.goals(event='started')) >= number, f'{number} goals')

    def close(self) -> None:
        for other in self.others:
            other.kill()


@pytest.fixture
def pair(start_cell: StartCell, address: str) -> Iterator[Pair]:
    options = ['--journal', address, '--standby', '--auto-resume']
    cell = start_cell(remembering(SMALL_CELL), run_options=options)
    cell.node.wait_ready('tree node ready: ')
    cell.connect()
    pair = Pair(cell)
    yield pair
    pair.close()


def assert_all_done_once(pair: Pair, address: str, leaders: int) -> None:
    """Compare the journal with what the controllers did."""
    events = kept_events(address)
    done = Counter((x.item, x.task) for x in events if isinstance(x, e.TaskSucceeded))
    ran = Counter(record['goal'] for record in pair.cell.goals(event='started'))
    assert [x.seq for x in events] == list(range(1, len(events) + 1))
    assert sum(isinstance(x, e.OrchestratorStarted) for x in events) == leaders
    assert not [x for x in events if isinstance(x, (e.TaskFailed, e.HoldRaised))]
    assert {x: n for x, n in done.items() if n != 1 and x[0]} == {}
    assert sum(task == 'pack' for _, task in done) == ITEMS
    assert set(ran.values()) == {1}
    assert ran.total() == done.total(), 'the controllers executed what the journal says, no more'


def test_9_4_standby_takes_over_when_leader_is_killed(pair: Pair, address: str) -> None:
    drawn, kills = random.Random(94), 3
    pair.cell.run_small(task='TASK_C', quantity=ITEMS)
    for number in range(1, kills + 1):
        standby = pair.start_standby()
        pair.until_goals(4 * number)
        moment = time.monotonic() + drawn.random() * 0.5
        pair.until(lambda until=moment: time.monotonic() > until, 'a moment')  # type: ignore[misc]
        pair.leader.kill()
        assert pair.lead(standby) < 10.0, 'about half a second on an idle machine'
    pair.cell.watch.until_ended('WO-1', within_s=60.0)
    assert_all_done_once(pair, address, kills + 1)
    pair.cell.stop()


def test_9_4_standby_recognizes_goals_ended_by_leader(pair: Pair, address: str) -> None:
    standby = pair.start_standby()
    pair.cell.run_small(task='TASK_C', quantity=ITEMS)
    pair.cell.watch.until_ended('WO-1', within_s=60.0)
    pair.leader.kill()
    pair.lead(standby)
    pair.cell.run_small(order='WO-2')
    pair.cell.watch.until_ended('WO-2', within_s=60.0)
    assert not [x for x in kept_events(address) if isinstance(x, e.HoldRaised)]
    pair.cell.stop()


def test_9_4_a_leader_that_stood_still_leads_no_more(pair: Pair, address: str) -> None:
    pair.cell.run_small(task='TASK_C', quantity=ITEMS)
    standby, old = pair.start_standby(), pair.leader
    pair.until_goals(3)
    old.send(signal.SIGSTOP)
    pair.lead(standby)
    started = len(pair.cell.goals(event='started'))
    pair.until_goals(started + 1)
    old.send(signal.SIGCONT)
    assert old.wait(10.0) == os.EX_TEMPFAIL, old.errors
    assert 'another orchestrator has taken over the cell' in old.errors
    assert 'Traceback' not in old.errors
    pair.cell.watch.until_ended('WO-1', within_s=60.0)
    pair.cell.stop()
    assert_all_done_once(pair, address, 2)


def test_9_4_a_restart_of_the_database_changes_nothing(
    pair: Pair, address: str, server: PostgresServer
) -> None:
    pair.cell.run_small(task='TASK_C', quantity=ITEMS)
    standby, leader = pair.start_standby(), pair.leader
    for number, how in enumerate((signal.SIGINT, signal.SIGQUIT), 1):
        pair.until_goals(3 * number)
        server.stop(how)
        server.start()
    pair.cell.watch.until_ended('WO-1', within_s=60.0)
    # Which of the two has the lock first is not said; then the other one ends or waits.
    if 'tree node ready: ' in standby.output:
        assert leader.wait(10.0) == os.EX_TEMPFAIL
        pair.lead(standby)
    pair.cell.stop()
    starts = 1 + ('tree node ready: ' in standby.output)
    assert_all_done_once(pair, address, starts)


def test_9_4_stopped_standby_leaves_leader_running(pair: Pair, address: str) -> None:
    pair.cell.run_small(quantity=ITEMS)
    standby = pair.start_standby()
    assert standby.stop() == 0, standby.errors
    standby.assert_clean()
    pair.cell.watch.until_ended('WO-1', within_s=60.0)
    pair.cell.stop()
    assert_all_done_once(pair, address, 1)


@pytest.mark.long
def test_9_4_status_and_diagnostics_tell_of_leader_and_standby(pair: Pair) -> None:
    messages: dict[str, str] = {}

    def hear(message: DiagnosticArray) -> None:
        messages.update({status.name: status.message for status in message.status})

    pair.cell.watch.ros.node.create_subscription(DiagnosticArray, '/diagnostics', hear, 10)
    host, leader = gethostname(), pair.leader.pid
    pair.until(lambda: 'bt_orchestrator: leadership' in messages, 'the diagnostics of the leader')
    assert messages['bt_orchestrator: leadership'] == 'leads; no standby can take over'
    assert f'led by {host}, process {leader}, epoch 1\n  no standby was heard' in status_of(pair)

    standby = pair.start_standby()
    could = f'standby {host}, process {standby.pid}: can take over'
    pair.until(lambda: could in status_of(pair), 'a standby that can take over')
    wanted = f'leads; {host}, process {standby.pid} can take over'
    pair.until(lambda: messages['bt_orchestrator: leadership'] == wanted, wanted)
    pair.until(
        lambda: messages.get(f'bt_orchestrator: standby {host}') == 'it can take over',
        'the diagnostics of the standby',
    )

    _, looked, _ = pair.cell.verb('doctor', '--node', 'bt_orchestrator')
    assert 'ok    standby: 1 of /bt_orchestrator can take over' in looked
    assert 'ok    tree node: /bt_orchestrator runs' in looked

    pair.cell.sims[0].kill()
    blind = f'standby {host}, process {standby.pid}: cannot take over: it does not see the servers'
    pair.until(lambda: blind in status_of(pair), 'a standby without servers')
    standby.kill()
    pair.until(lambda: 'it was heard last at' in status_of(pair), 'a standby that is gone')


def status_of(pair: Pair) -> str:
    status, output, errors = pair.cell.verb('status')
    assert (status, errors) == (0, '')
    return output


def test_9_4_standby_requires_postgresql_journal(start_cell: StartCell, address: str) -> None:
    cell = start_cell(run_options=['--journal', 'journal.db', '--standby'])
    assert cell.node.wait() == 1
    assert 'expected --journal postgresql://USER@HOST/DATABASE/CELL' in cell.node.errors
    assert 'Traceback' not in cell.node.errors
