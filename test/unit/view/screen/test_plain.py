"""The view in plain lines, and that for machines."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from fakes import statuses

from bt_orchestrator.model import events as e
from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.stop_reason import Wish
from bt_orchestrator.view.screen import machine, plain, words
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.machine import JsonView
from bt_orchestrator.view.screen.plain import EventLines, PlainView

NODE = Shell()


class Time:
    """Stands for the module `time`: it passes when the test says so."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def monotonic(self) -> float:
        """Return the time."""
        return self.now_s


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Time:
    clock = Time()
    monkeypatch.setattr(plain, 'time', clock)
    monkeypatch.setattr(machine, 'time', clock)
    return clock


def raised() -> e.HoldRaised:
    return e.HoldRaised(
        seq=1, time=0.0, hold='1', task='work', reason='aborted', answers=('retry', 'skip')
    )


def branch(status: Outcome) -> Branch:
    leaf = Branch('work', status, '', is_decorator=False, children=())
    return Branch('cell', Outcome.RUNNING, '', is_decorator=False, children=(leaf,))


def test_7_1_every_view_offers_the_answers_of_its_role() -> None:
    about = {'holds': [statuses.hold(answers=('retry', 'abort_job'))]}
    status = statuses.status(unauthenticated_role=Role.OPERATE, **about)
    output: list[str] = []
    lines = EventLines(NODE, output.append)
    lines.on_status(status)
    assert output[1:] == [
        '  bt-orchestrator answer 1 retry --reason "WHY"',
        '  an engineer may also: abort_job',
    ]
    output.clear()
    lines.on_event(replace(raised(), answers=('retry', 'abort_job')))
    assert output[-1] == '  an engineer may also: abort_job'
    output.clear()
    JsonView('/node', output.append).on_status(status)
    printed = json.loads(output[0])['status']
    (hold,) = printed['holds']
    assert machine.read_status(printed) == status
    assert hold['answers'] == ['retry', 'abort_job']
    assert hold['answers_allowed'] == ['retry']
    assert hold['answer_roles'] == {'retry': ['operate', 'engineer'], 'abort_job': ['engineer']}


def test_status_prints_fully_once_then_only_changes() -> None:
    output: list[str] = []
    view = PlainView(NODE, output.append)
    view.on_status(statuses.status())
    assert output[0] == 'cell small_cell: Execute for 12.0 s, belt at rest, seq 7'
    output.clear()

    view.on_status(statuses.status())
    gone = [statuses.component('worker', available=False)]
    view.on_status(statuses.status(components=gone))
    view.on_status(statuses.status(components=gone))
    view.on_status(statuses.status())
    trouble = 'worker: no action server at /worker/task'
    assert output == [trouble, f'over: {trouble}']
    output.clear()
    view.on_status(statuses.status(journal_failure='disk full'))
    assert output == ['NOTHING IS DONE ANY MORE: disk full']
    output.clear()
    view.on_status(statuses.status(disk_wait='the last event'))
    assert output[0] == 'WAITS FOR THE DISK: the last event'


def test_stop_and_its_origin_are_printed_once() -> None:
    output: list[str] = []
    view = PlainView(NODE, output.append)
    view.on_status(statuses.status())
    output.clear()
    for _ in range(2):
        view.on_status(statuses.status(wish=Wish('stop'), waits_for='start'))
    view.on_status(statuses.status())
    assert output == ['somebody said stop; orders wait for start']


def test_a_hold_is_told_with_what_to_type() -> None:
    output: list[str] = []
    PlainView(NODE, output.append).on_event(raised())
    assert [line.strip() for line in output] == [
        '0.00 s  HOLD 1: work: aborted',
        'bt-orchestrator answer 1 retry --reason "WHY"',
        'or skip in place of retry',
    ]


def test_hold_of_whole_cell_shows_its_message() -> None:
    output: list[str] = []
    hold = e.HoldRaised(
        seq=1, time=0.0, hold='1', reason='restarted', message='1 job', answers=('resume',)
    )
    PlainView(NODE, output.append).on_event(hold)
    assert [line.strip() for line in output] == [
        '0.00 s  HOLD 1: restarted (1 job)',
        'bt-orchestrator cell resume --hold 1 --reason "WHY"',
    ]


def test_events_alone() -> None:
    output: list[str] = []
    view = EventLines(NODE, output.append)
    view.on_status(statuses.status())
    view.on_tree(branch(Outcome.RUNNING))
    view.on_blackboard({'k': 'v'})
    view.refresh()
    assert output == []
    view.on_event(raised())
    assert output[0].endswith('HOLD 1: work: aborted')
    assert len(output) == 3, 'and what to type'


def test_hold_raised_before_listening_is_printed_once() -> None:
    output: list[str] = []
    view = EventLines(NODE, output.append)
    for _ in range(2):
        view.on_status(statuses.status(holds=[statuses.hold()]))
    assert [line.strip() for line in output] == [
        words.hold_text(statuses.hold()),
        'bt-orchestrator answer 1 retry --reason "WHY"',
        'or skip in place of retry',
    ]


def test_aborted_cell_shows_next_command_once() -> None:
    lines: list[str] = []
    for view in (EventLines(NODE, lines.append), PlainView(NODE, lines.append)):
        view.on_status(statuses.status())
        lines.clear()
        for seq in (7, 8):
            view.on_status(statuses.status(state=PackmlState.ABORTED, seq=seq))
        assert [line.split(' --')[0] for line in lines] == ['next: bt-orchestrator cell clear'] * 2


def test_notes_are_told_once() -> None:
    output: list[str] = []
    view = EventLines(NODE, output.append)
    for notes in (['a'], ['a', 'b'], ['b']):
        view.on_notes(notes)
    assert output == ['a', 'b']


def test_a_node_that_goes_away_and_comes_back(clock: Time) -> None:
    output: list[str] = []
    view = PlainView(NODE, output.append)
    view.on_status(statuses.status())
    output.clear()
    for clock.now_s in (2.9, 3.1, 4.0):
        view.refresh()
    assert output == ['no news from /bt_orchestrator for 3.1 s']
    view.on_status(statuses.status())
    assert output[1] == 'cell small_cell: Execute for 12.0 s, belt at rest, seq 7'


def test_changes_of_tree_and_blackboard() -> None:
    output: list[str] = []
    view = PlainView(NODE, output.append)
    view.on_tree(branch(Outcome.RUNNING))
    view.on_tree(branch(Outcome.SUCCESS))
    view.on_blackboard({'/cell/belt': 'moving', '/cell/beat': '1'})
    view.on_blackboard({'/cell/belt': 'at rest'})
    assert output == [
        'tree /cell  running',
        'tree /cell/work  running',
        'tree /cell/work  success',
        'blackboard /cell/belt  moving',
        'blackboard /cell/beat  1',
        'blackboard /cell/belt  at rest',
        'blackboard /cell/beat  is gone',
    ]


def test_machines_get_what_is_different(clock: Time) -> None:
    output: list[str] = []
    view = JsonView(NODE.node, output.append)
    view.on_status(statuses.status(jobs=[statuses.job(expected_end_s=9.0)]))
    view.on_status(
        statuses.status(
            stamp=1001.0,
            state_times={PackmlState.EXECUTE: 13.0},
            jobs=[statuses.job(expected_end_s=8.0)],
        )
    )
    view.on_status(statuses.status(seq=8))
    view.on_event(raised())
    view.on_tree(branch(Outcome.SUCCESS))
    view.on_blackboard({'/cell/belt': 'moving'})
    for clock.now_s in (3.1, 9.0):
        view.refresh()
    view.on_status(statuses.status(seq=8))
    records = [json.loads(line) for line in output]
    kinds = [record['kind'] for record in records]
    assert kinds == ['status', 'status', 'tree', 'blackboard', 'away', 'status']
    assert records[0]['status']['cell'] == 'small_cell'
    assert records[2]['tree']['children'][0] == {
        'name': 'work',
        'status': 'SUCCESS',
        'message': '',
        'children': [],
    }
    assert records[3]['values'] == {'/cell/belt': 'moving'}
    assert records[4] == {'kind': 'away', 'node': NODE.node, 'silent_s': 3.1}


def test_event_lines_continue_across_clock_step() -> None:
    output: list[str] = []
    lines = EventLines(NODE, output.append)
    states = [e.CellStateChanged(state=word, previous='Idle') for word in ('Starting', 'Execute')]
    lines.on_event(states[0].stamped(1, 7200.0))
    lines.on_event(e.ClockStepped(seconds=-3600.0).stamped(2, 3604.0))
    lines.on_event(states[1].stamped(3, 3605.0))
    assert [line.split(' s ')[0].strip() for line in output] == ['0.00', '5.00']
