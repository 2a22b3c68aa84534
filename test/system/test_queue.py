"""The queue and its jobs on real ROS 2: verbs, services, and the action run_job."""

from __future__ import annotations

import json
import time
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from bt_orchestrator_interfaces import srv
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder
from cell_processes import CellProcesses, StartCell, small_script
from node_watcher import WHO, NodeWatcher

WHY = ['--reason', 'rush', '--who', 'Ada']

LONG = 5000
"""Items of a job that does not end by itself: a quarter of an hour, also where verbs are slow."""


def order_files(cell: CellProcesses, *names: str, quantity: int = 1) -> list[str]:
    paths = []
    for name in names:
        path = cell.folder / f'{name}.order.yaml'
        path.write_text(f'{{order: {name}, script: small, quantity: {quantity}}}')
        paths.append(str(path))
    return paths


def queue(cell: CellProcesses) -> list[str]:
    """Return the queue as the verb lists it."""
    status, output, _ = cell.verb('queue', '--json')
    assert status == 0
    waiting = [job for job in json.loads(output)['jobs'] if job['position']]
    assert [job['position'] for job in waiting] == list(range(1, len(waiting) + 1))
    return [f'{job["id"]} {job["state"]}' for job in waiting]


def test_the_queue_is_changed_while_a_job_runs(small_cell: CellProcesses) -> None:
    watch = small_cell.watch
    small_cell.script(small_script())
    small_cell.run_small(quantity=LONG, order='long')
    watch.until('item.removed')

    orders = order_files(small_cell, 'a', 'b', 'c')
    broken = [*orders, *order_files(small_cell, 'long')]
    status, _, errors = small_cell.verb('submit', *broken)
    assert status == 1
    assert 'order long was given before' in errors
    assert 'a fits, but was not queued because of the others' in errors
    assert small_cell.verb('submit', *orders)[0] == 0
    assert queue(small_cell) == [f'{name} AllowedToStart' for name in 'abc']

    for words in (['move', 'c', '1'], ['hold', 'a'], ['update', 'b', '--quantity', '2']):
        status, _, errors = small_cell.verb('queue', *words, *WHY)
        assert status == 0, errors
    assert queue(small_cell) == ['c AllowedToStart', 'a NotAllowedToStart', 'b AllowedToStart']
    change = ['--priority', '7', '--due', '2036-05-18T06:00Z', '--details', '{"lot": 7}']
    status, _, errors = small_cell.verb('job', 'update', 'a', *change, *WHY)
    assert status == 0, errors
    assert 'NotAllowedToStart, priority 7, due 2036-05-18' in small_cell.verb('queue')[1]
    answer = watch.call(srv.QueueList, 'queue/list', srv.QueueList.Request())
    assert list(answer.details) == ['', '{"lot": 7}', '']
    updated = watch.until('job.updated', job='a')
    assert (updated['priority'], updated['due']) == (7, 2094703200.0)
    moved = watch.until('operator.decided', answer='move')
    assert (moved['job'], moved['who'], moved['reason']) == ('c', 'Ada', 'rush')
    assert 'bt-orchestrator at ' in moved['origin']

    refused = small_cell.verb('job', 'hold', 'long', *WHY)
    assert refused[0] == 1
    assert 'RevokeStart (hold) is for jobs that are AllowedToStart' in refused[2]
    assert small_cell.verb('job', 'stop', 'long', *WHY)[0] == 0
    assert watch.until('job.completed', job='long')['exit_status'] == 'stopped'
    assert watch.until('job.completed', job='b')['counts']['packed'] == 2
    assert [e['job'] for e in watch.seen('job.started')] == ['long', 'c', 'b']

    assert small_cell.verb('job', 'release', 'a', *WHY)[0] == 0
    assert watch.until_ended('a').packed == 1
    small_cell.stop()


def test_6_7_job_waits_for_start_across_restart(start_cell: StartCell, tmp_path: Path) -> None:
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start_cell(run_options=['--journal', str(journal), '--auto-resume'])
    cell.connect()
    cell.script(small_script())
    order = cell.folder / 'late.order.yaml'
    order.write_text(f'{{order: late, script: small, quantity: 1, start: {in_seconds(3600.0)}}}')
    status, _, errors = cell.verb('submit', str(order))
    assert status == 0, errors
    assert 'waits for its start' in cell.verb('queue')[1]
    cell.kill_and_restart_node()
    (job,) = cell.watch.call(srv.ListJobs, 'list_jobs', srv.ListJobs.Request()).jobs
    assert (job.job.state, job.job.awaits_start) == ('AllowedToStart', True)
    status, _, errors = cell.verb('job', 'update', 'late', '--start', in_seconds(2.0), *WHY)
    assert status == 0, errors
    start = cell.watch.until('job.updated', job='late')['start']
    assert cell.watch.until('job.started', job='late')['time'] >= start
    assert cell.watch.until_ended('late').packed == 1
    cell.stop()


def in_seconds(seconds: float) -> str:
    """Return a time from now as an order has it."""
    return datetime.fromtimestamp(time.time() + seconds, timezone.utc).isoformat()


@pytest.mark.long
@pytest.mark.timeout(600)
def test_jobs_of_the_action_run_job(start_cell: StartCell) -> None:
    cell = start_cell(fail=['worker.TASK_A#2=abort'])
    cell.connect()
    _what_is_refused_at_any_door_is_on_record(cell)
    _a_job_is_run_as_an_action(cell)
    _an_action_whose_order_is_wrong_ends_with_the_findings(cell)
    _cancelling_the_action_aborts_the_job(cell)
    cell.stop()


def run_job(cell: CellProcesses, feedback: list[Any], **fields: Any) -> Any:
    """Start a goal of run_job and return its handle."""
    goal = RunJob.Goal(who='Ada', reason='test', **fields)
    handle = cell.watch.ros.start(
        f'{cell.watch.name}/run_job', RunJob, goal, on_feedback=feedback.append
    )
    assert handle.accepted
    return handle


def _what_is_refused_at_any_door_is_on_record(cell: CellProcesses) -> None:
    watch = cell.watch
    path = str(cell.script(small_script()))
    wrong = str(cell.script(small_script(options=', retires: 2'), 'wrong'))
    by = {'who': 'Ada', 'origin': 'the test', 'reason': 'rush'}
    good = WorkOrder(order='A', script=path, quantity=1)
    held = srv.QueueAdd.Request(orders=[good], held=True, **by)
    assert watch.call(srv.QueueAdd, 'queue/add', held).accepted
    asked = [
        ('submit_order', srv.SubmitOrder.Request(order='B', script=wrong, quantity=1, **by)),
        ('submit_order', srv.SubmitOrder.Request(order='C', script='smal', **by)),
        ('queue/add', srv.QueueAdd.Request(orders=[], **by)),
        (
            'queue/add',
            srv.QueueAdd.Request(
                orders=[WorkOrder(order='D', script=path, quantity=1), WorkOrder(script=wrong)],
                **by,
            ),
        ),
        ('queue/update', srv.QueueUpdate.Request(job='A', script='smal', **by)),
        ('queue/update', srv.QueueUpdate.Request(job='Z', **by)),
        ('command', srv.Command.Request(command='dance', **by)),
        ('command', srv.Command.Request(command='clear', **by)),
    ]
    for service, request in asked:
        kind = getattr(srv, type(request).__name__.removesuffix('_Request'))
        assert not watch.call(kind, service, request).accepted, service
    for fields in ({'order': WorkOrder(order='E', script=wrong)}, {'text': '{order: F'}):
        end = watch.ros.result(run_job(cell, [], **fields)).result
        assert (end.exit_status, bool(end.findings)) == ('refused', True)

    watch.until('operator.refused', count=11)
    recorded = watch.seen('operator.refused')
    assert [(event['command'], event.get('job'), event['who']) for event in recorded] == [
        *(('add', job, 'Ada') for job in ('B', 'C', None, 'D', None)),
        *(('update', job, 'Ada') for job in 'AZ'),
        *((word, None, 'Ada') for word in ('dance', 'clear')),
        *(('add', job, 'Ada') for job in ('E', None)),
    ]
    assert {event['origin'] for event in recorded} == {'the test', 'run_job'}
    messages = [event['message'] for event in recorded]
    assert messages[0].startswith(f'B is refused with 1 finding: {wrong}:')
    assert 'a task has no key `retires`' in messages[0]
    assert 'there is no script `smal`' in messages[1]
    assert messages[3] == 'D fits, but was not queued because of the others'
    assert messages[4].startswith(f'{wrong} is refused with 1 finding: ')
    assert 'there is no script `smal`' in messages[5]
    assert messages[6] == 'Z is not there; in the queue: A'
    cancel = srv.QueueCommand.Request(command='cancel', job='A', **by)
    assert watch.call(srv.QueueCommand, 'queue/command', cancel).accepted
    until_listed(cell)


def _a_job_is_run_as_an_action(cell: CellProcesses) -> None:
    path = str(cell.script(small_script(options=', on_failure: continue')))
    feedback: list[Any] = []
    handle = run_job(cell, feedback, order=WorkOrder(order='run', script=path, quantity=3))
    other = run_job(cell, [], text=f'{{order: beside, script: {path}, quantity: 1}}')

    end = cell.watch.ros.result(handle)
    assert end.status == GoalStatus.STATUS_SUCCEEDED
    result = end.result
    assert (result.job, result.exit_status, result.status.packed) == ('run', 'completed', 3)
    assert [(i.id, i.outcome, list(i.nonconforming)) for i in result.items] == [
        ('run/1', 'packed', []),
        ('run/2', 'packed', ['work']),
        ('run/3', 'packed', []),
    ]
    assert 'measurement' in json.loads(result.items[0].results)['work']
    (failure,) = result.failures
    assert (failure.item, failure.task, failure.reason) == ('run/2', 'work', 'aborted')
    packed = [message.feedback.status.packed for message in feedback]
    assert packed == sorted(packed)
    assert {'Running'} <= {message.feedback.status.state for message in feedback}
    assert cell.watch.ros.result(other).result.exit_status == 'completed'


def _an_action_whose_order_is_wrong_ends_with_the_findings(cell: CellProcesses) -> None:
    order = WorkOrder(script='smal', quantity=1)
    end = cell.watch.ros.result(run_job(cell, [], order=order))
    assert (end.status, end.result.exit_status) == (GoalStatus.STATUS_ABORTED, 'refused')
    assert end.result.findings
    path = str(cell.script(small_script()))
    twice = WorkOrder(order='twice', script=path, quantity=1)
    first = run_job(cell, [], order=twice)
    again = cell.watch.ros.result(run_job(cell, [], order=twice)).result
    assert again.message == 'order twice was given before; choose another id'
    assert cell.watch.ros.result(first).result.exit_status == 'completed'


def answer_for_the_slots(watch: NodeWatcher, job: str) -> None:
    """Say of items that were being placed or taken out that they were, until a job is aborted."""
    answered = set()

    def is_aborted() -> bool:
        for hold in watch.status.holds:
            if hold.id not in answered:
                answered.add(hold.id)
                watch.answer(hold.id, 'mark_done')
        return bool(watch.seen('job.aborted', job=job))

    watch.ros.spin_until(is_aborted, f'the end of {job}')


def _cancelling_the_action_aborts_the_job(cell: CellProcesses) -> None:
    watch = cell.watch
    text = small_script().replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    path = str(cell.script(text))
    running = run_job(cell, [], order=WorkOrder(order='on_line', script=path, quantity=LONG))
    waiting = run_job(cell, [], order=WorkOrder(order='behind', script=path, quantity=LONG))
    watch.until('item.removed', job='on_line')

    for handle, packed in ((waiting, False), (running, True)):
        watch.ros.wait(handle.cancel_goal_async(), 'the answer to the cancel request')
        answer_for_the_slots(watch, 'behind' if handle is waiting else 'on_line')
        end = watch.ros.result(handle)
        assert (end.status, end.result.exit_status) == (GoalStatus.STATUS_CANCELED, 'aborted')
        assert bool(end.result.status.packed) is packed
    assert watch.seen('job.aborted', job='behind')[0]['counts']['started'] == 0


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_line_at_work_is_commanded(small_cell: CellProcesses) -> None:
    """One job runs all the time, until the last step ends it."""
    run_long(small_cell)
    _an_order_is_added_held_run_next_and_another_cancelled(small_cell)
    _a_job_that_runs_is_paused_and_resumed(small_cell)
    _the_line_stops_after_the_current_item_and_goes_on(small_cell)
    _a_stop_after_the_current_job_is_taken_back(small_cell)
    _the_line_stops_after_an_aborted_job_which_is_cleared(small_cell)
    small_cell.stop()


def run_long(cell: CellProcesses) -> None:
    """Let a job run on the line that ends only when it is told to."""
    cell.run_small(quantity=LONG, order='long')
    cell.watch.until('item.removed')


def ask(cell: CellProcesses, *words: str) -> None:
    """Carry out a verb."""
    status, _, errors = cell.verb(*words, *WHY)
    assert status == 0, errors


def ask_to_begin(cell: CellProcesses) -> None:
    for verb in ('reset', 'start'):
        ask(cell, verb)


def pause(cell: CellProcesses, job: str) -> None:
    """Pause the job that runs, and wait until its items have left the line."""
    ask(cell, 'job', 'pause', job)
    until_job(cell, job, 'InterruptedSuspended')
    cell.watch.until_status(lambda s: not any(x.slot for x in s.sections), 'an empty line')


def until_job(cell: CellProcesses, job: str, state: str) -> None:
    """Wait until a job is in a state and substate."""

    def is_so(status: Any) -> bool:
        return [f'{j.state}{j.substate}' for j in status.jobs if j.id == job] == [state]

    cell.watch.until_status(is_so, f'{job} to be {state}')


def until_listed(cell: CellProcesses, *jobs: str) -> None:
    """Wait until these jobs and no others are listed."""
    cell.watch.until_status(lambda s: [j.id for j in s.jobs] == list(jobs), f'only {jobs}')


def decided(cell: CellProcesses, since_seq: int) -> list[str]:
    """Return what the journal says that was asked for by `ask`, since an event."""
    events = [
        event
        for event in cell.watch.seen('operator.decided')
        if event['seq'] > since_seq and event['answer'] != 'add'
    ]
    assert {(event['who'], event['reason']) for event in events} == {('Ada', 'rush')}
    assert all(event['origin'].startswith('bt-orchestrator at ') for event in events)
    return [f'{event["answer"]} {event.get("job", "")}'.strip() for event in events]


def _an_order_is_added_held_run_next_and_another_cancelled(cell: CellProcesses) -> None:
    since = cell.watch.events[-1]['seq']
    assert cell.verb('submit', *order_files(cell, 'a', 'b'))[0] == 0
    held = order_files(cell, 'c')
    assert cell.verb('queue', 'add', *held, '--held')[0] == 0
    assert queue(cell)[-1] == 'c NotAllowedToStart'
    ask(cell, 'job', 'next', 'c')
    assert queue(cell) == [f'{name} AllowedToStart' for name in 'cab']
    ask(cell, 'job', 'cancel', 'b')
    until_listed(cell, 'long', 'c', 'a')
    assert decided(cell, since) == ['next c', 'cancel b']
    for job in 'ca':
        cancel = srv.QueueCommand.Request(command='cancel', job=job, who=WHO, reason='test')
        assert cell.watch.call(srv.QueueCommand, 'queue/command', cancel).accepted
    until_listed(cell, 'long')


def _a_job_that_runs_is_paused_and_resumed(cell: CellProcesses) -> None:
    watch = cell.watch
    since = watch.events[-1]['seq']
    pause(cell, 'long')
    ask(cell, 'job', 'resume', 'long')
    until_job(cell, 'long', 'Running')
    watch.until('item.placed', len(watch.seen('item.placed')) + 1)
    assert decided(cell, since) == ['pause long', 'resume long']


def _the_line_stops_after_the_current_item_and_goes_on(cell: CellProcesses) -> None:
    watch = cell.watch
    since = watch.events[-1]['seq']
    ask(cell, 'cell', 'stop-after', 'item')
    watch.until_state('Stopped')
    assert not any(section.slot for section in watch.status.sections)
    ask_to_begin(cell)
    watch.until_state('Execute')
    watch.until('item.placed', len(watch.seen('item.placed')) + 1)
    assert decided(cell, since) == ['stop_after_item', 'reset', 'start']


def _a_stop_after_the_current_job_is_taken_back(cell: CellProcesses) -> None:
    watch = cell.watch
    since = watch.events[-1]['seq']
    ask(cell, 'cell', 'stop-after', 'job')
    watch.until_status(lambda s: s.stop_after == 'job', 'the stop that is to come')
    ask(cell, 'cell', 'stop-after', 'never')
    watch.until_status(lambda s: s.state == 'Execute' and not s.stop_after, 'no stop to come')
    assert decided(cell, since) == ['stop_after_job', 'stop_after_never']


def _the_line_stops_after_an_aborted_job_which_is_cleared(cell: CellProcesses) -> None:
    watch = cell.watch
    since = watch.events[-1]['seq']
    assert cell.verb('submit', *order_files(cell, 'd'))[0] == 0
    ask(cell, 'cell', 'stop-after', 'job')
    pause(cell, 'long')
    ask(cell, 'job', 'abort', 'long')
    until_job(cell, 'long', 'Aborted')
    watch.until_state('Stopped')
    ask(cell, 'job', 'clear', 'long')
    until_listed(cell, 'd')
    ask_to_begin(cell)
    assert watch.until_ended('d').packed == 1
    assert [event['job'] for event in watch.seen('job.started')] == ['long', 'd']
    assert decided(cell, since) == [
        'stop_after_job',
        'pause long',
        'abort long',
        'clear long',
        'reset',
        'start',
    ]
