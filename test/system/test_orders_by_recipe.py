"""Orders by recipe in a real node: generated beside the line, queued as a whole, or not at all."""

from __future__ import annotations

import os
import signal
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder
from bt_orchestrator_interfaces.srv import (
    Command,
    QueueAdd,
    QueueCommand,
    QueueList,
    QueueUpdate,
    SubmitOrder,
)
from cell_processes import SMALL_CELL, CellProcesses, StartCell, runs, small_script
from diagnostic_msgs.msg import KeyValue

from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.model.by import By
from bt_orchestrator.model.requests import ask

LONG = 5000
"""Items of a job that does not end before the node was killed and asked again."""

MODULE = 'bt_orchestrator.extensions.recipes.generating.process'

ABLE = {
    'feeder': 'feed: {task: TASK_A, qty_change: 1}',
    'worker': 'work: {task: TASK_A}',
    'packer': 'work: {task: TASK_A}, pack: {task: TASK_A, qty_change: -1, runs_for: all}',
}

RECIPE = """\
recipe: BOX
version: 1
script: box
params: {lot: {type: str, default: none}}
operations:
  - {id: feed, do: feed}
  - {id: work, do: work}
  - {id: pack, do: pack}
"""


def able_cell() -> str:
    """Return the small cell, whose components say what they can do; nobody has to release it.

    Its packer takes twice as long for the same work as its worker.
    """
    before, packer, after = SMALL_CELL.partition('packer:')
    text = f'{before}{packer}{after.replace("TASK_A: 1.0", "TASK_A: 2.0")}release: automatic\n'
    for name, can in ABLE.items():
        task = f'action: {name}/task'
        end = ',' if '{' in text.split(task, maxsplit=1)[0].rsplit('\n', 1)[1] else '\n   '
        text = text.replace(task, f'{task}{end} capabilities: {{{can}}}')
    return text


def by_recipe(name: str, version: int = 0, **bind: str) -> WorkOrder:
    bound = [KeyValue(key=key, value=value) for key, value in bind.items()]
    return WorkOrder(order=name, recipes=['BOX'], version=version, quantity=1, bind=bound)


def answer(cell: CellProcesses, future: Any) -> Any:
    cell.watch.ros.spin_until(future.done, 'the answer')
    return future.result()


@pytest.mark.usefixtures('children_by_python')
@pytest.mark.long
def test_orders_by_recipe(start_cell: StartCell, tmp_path: Path) -> None:
    recipes = tmp_path / 'recipes'
    recipes.mkdir()
    (recipes / 'box.yaml').write_text(RECIPE)
    journal = str(tmp_path / 'journal.sqlite3')
    options = ['--recipes', str(recipes), '--journal', journal, '--auto-resume']
    cell = start_cell(cell=able_cell(), run_options=options)
    cell.connect()
    _a_node_that_is_killed_while_it_generates_has_queued_nothing(cell)
    _a_request_is_refused_as_a_whole(cell)
    _run_job_takes_the_text_of_an_order(cell)
    _what_is_out_of_service_is_left_out(cell)
    _queued_jobs_follow_what_is_out_of_service(cell)
    _the_rest_of_a_job_is_made_without_it(cell)
    _what_if_in_an_outage_comes_true(cell, recipes)
    _what_if_with_a_requeue_comes_true(cell, recipes)
    _a_version_says_one_thing(cell, recipes)
    cell.stop()


def _a_node_that_is_killed_while_it_generates_has_queued_nothing(cell: CellProcesses) -> None:
    request = SubmitOrder.Request(order='A', recipes=['BOX'], quantity=1)
    first = cell.watch.begin(SubmitOrder, 'submit_order', request)
    child = _stopped_child(cell)
    # Held, so that nothing runs when the node is killed.
    script = str(cell.script(small_script()))
    request = QueueAdd.Request(orders=[WorkOrder(order='S', script=script, quantity=1)], held=True)
    assert cell.watch.call(QueueAdd, 'queue/add', request).accepted
    assert not first.done(), 'the order by script came first'
    _begin_anew(cell, child)
    request = QueueAdd.Request(orders=[by_recipe('A')], held=True)
    assert cell.watch.call(QueueAdd, 'queue/add', request).accepted, 'its id was not used'


def _stopped_child(cell: CellProcesses) -> int:
    """Return the process that generates, which does not go on."""
    child = cell.child(MODULE)
    os.kill(child, signal.SIGSTOP)
    return child


def _begin_anew(cell: CellProcesses, child: int) -> None:
    """Kill the node, whose process ends with it, and start another one."""
    cell.node.kill()
    os.kill(child, signal.SIGCONT)
    cell.watch.ros.spin_until(lambda: not runs(child, MODULE), 'the end of the process')
    cell.start_node()
    cell.node.wait_ready()


def _a_request_is_refused_as_a_whole(cell: CellProcesses) -> None:
    orders = [by_recipe('B'), by_recipe('C', 3), by_recipe('D', feed='packer')]
    response = cell.watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=orders))
    assert not response.accepted
    text = ' '.join(finding for entry in response.answers for finding in entry.findings)
    assert 'recipe BOX has no version 3; there is 1' in text
    assert 'bind feed: `packer` does not have `feed`' in text
    both = WorkOrder(order='E', recipes=['BOX'], script='small', quantity=1)
    response = cell.watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=[both]))
    assert 'the order names recipe and script; keep one' in response.answers[0].findings[0]
    queue = cell.watch.call(QueueList, 'queue/list', QueueList.Request())
    assert [job.id for job in queue.jobs] == ['S', 'A']


def _run_job_takes_the_text_of_an_order(cell: CellProcesses) -> None:
    text = 'order: F\nrecipe: [BOX]\nbind: {work: packer}\nquantity: 1\nparams: {lot: A7}\n'
    handle = cell.watch.ros.start(f'{cell.watch.name}/run_job', RunJob, RunJob.Goal(text=text))
    result = cell.watch.ros.result(handle).result
    assert (result.exit_status, result.status.packed) == ('completed', 1), result.message
    queued = cell.watch.until('job.queued', job='F')
    assert (queued['recipe'], queued['recipe_version']) == ('BOX', 1)
    assert queued['choice'] == {'recipes': ['BOX'], 'bind': {'work': 'packer'}}
    assert cell.watch.until('task.started', job='F', task='work')['component'] == 'packer'


def _what_is_out_of_service_is_left_out(cell: CellProcesses) -> None:
    out = Command.Request(command='out_of_service', component='packer', reason='worn')
    assert cell.watch.call(Command, 'command', out).accepted
    response = cell.watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=[by_recipe('G')]))
    assert not response.accepted
    assert 'out of service' in response.answers[0].findings[0]
    back = Command.Request(command='in_service', component='packer', reason='mended')
    assert cell.watch.call(Command, 'command', back).accepted
    # Generated behind A, so that A's change for the packer is over when the next part begins.
    again = QueueAdd.Request(orders=[by_recipe('G')], held=True)
    assert cell.watch.call(QueueAdd, 'queue/add', again).accepted


def _queued_jobs_follow_what_is_out_of_service(cell: CellProcesses) -> None:
    watch = cell.watch
    whole = watch.until('job.queued', job='A')['digest']
    assert watch.command('out_of_service', component='worker', who='Ada').accepted
    without = watch.until('job.updated', job='A')
    assert without['digest'] != whole
    assert without['choice'] == {'recipes': ['BOX']}, 'what was ordered stays'
    decided = watch.until('operator.decided', job='A', answer='update')
    assert 'worker is out of service; made anew: ' in decided['reason'], decided

    assert watch.command('out_of_service', component='feeder', who='Ada').accepted
    watch.ros.spin_until(
        lambda: any('only feeder could' in event.get('message', '') for event in watch.events),
        'the reason why the job cannot be made',
    )
    cell.kill_and_restart_node()
    watch.until_status(
        lambda view: ('A', ['feeder']) in [(job.id, list(job.unavailable)) for job in view.jobs],
        'the job lacks its feeder alone',
    )

    for component in ('feeder', 'worker'):
        assert watch.command('in_service', component=component, who='Ada').accepted
    watch.until('job.updated', job='A', digest=whole)


def _the_rest_of_a_job_is_made_without_it(cell: CellProcesses) -> None:
    watch = cell.watch
    whole = watch.until('job.queued', job='A')['digest']
    order = WorkOrder(order='H', recipes=['BOX'], quantity=LONG)
    assert watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=[order])).accepted
    watch.until('item.placed', job='H')
    info = watch.command('out_of_service', component='worker', who='Ada')
    assert 'to make the rest without it now: job requeue H' in info.message
    # A kill between the record of a goal and its sending would ask about that goal.
    watch.until_status(lambda info: info.stands.cause, 'the line to stand')

    requeue = QueueCommand.Request(command='requeue', job='H', reason='worn')
    child = _stopped_child(cell)
    watch.begin(QueueCommand, 'queue/command', requeue)
    _begin_anew(cell, child)
    watch.until_status(
        lambda info: {job.id: job.ending for job in info.jobs if job.id[0] == 'H'} == {'H': ''},
        'nothing has changed',
    )

    info = watch.call(QueueCommand, 'queue/command', requeue)
    assert info.accepted, (info.message, info.findings)
    assert 'its items on the line still need worker and wait' in info.message
    rest = watch.until('job.queued', job='H-rest')
    assert (rest['rest_of'], rest['position'], rest['anew']['without']) == ('H', 1, ['worker'])
    assert watch.until('job.stopping', job='H')['seq'] < rest['seq']
    begun = len({entry['item'] for entry in watch.seen('cycle.started', job='H')})
    assert rest['quantity'] == LONG - begun
    status = watch.until_status(
        lambda info: any(job.id == 'H-rest' and job.made_anew for job in info.jobs), 'the rest'
    )
    (job,) = (entry for entry in status.jobs if entry.id == 'H-rest')
    assert (job.rest_of, list(job.made_without)) == ('H', ['worker'])
    assert job.made_per_item_s >= job.made_before_s > 0

    abort = QueueCommand.Request(command='abort', job='H', reason='they wait for it')
    assert watch.call(QueueCommand, 'queue/command', abort).accepted
    watch.until('job.aborted', job='H')
    assert watch.until('task.started', job='H-rest', task='work')['component'] == 'packer'
    # Paused: the last items of H-rest stay on the line, and H-end cannot begin before its cancel.
    assert watch.command('pause').accepted
    requeue.job, requeue.order = 'H-rest', 'H-end'
    assert watch.call(QueueCommand, 'queue/command', requeue).accepted
    cancel = QueueCommand.Request(command='cancel', job='H-end', reason='enough')
    assert watch.call(QueueCommand, 'queue/command', cancel).accepted
    assert watch.command('resume').accepted
    assert watch.until('job.completed', job='H-rest')['exit_status'] == 'stopped'
    assert watch.command('in_service', component='worker', who='Ada').accepted
    watch.until('job.updated', count=2, job='A', digest=whole)


def _what_if_in_an_outage_comes_true(cell: CellProcesses, recipes: Path) -> None:
    """The job on the line does not need the worker; the one behind it is made anew."""
    watch = cell.watch
    orders = [by_recipe('X', work='packer'), by_recipe('Y')]
    for order in orders:
        order.quantity = 15
    assert watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=orders)).accepted
    watch.until('item.removed', job='X')
    lost = ask('component.out_of_service', By('Ada', 'test', 'worn'), component='worker')
    with open_door(watch.name, 10.0) as door:
        moment = door.moment()
        assert door.ask(lost).accepted
    with closing(PlanningProcess([], [recipes])) as planning:
        expected = planning.what_if(moment, [lost])
    assert expected.refusals == ()
    ends = {entry.job: entry.ends_s for entry in expected.after if entry.ends_s is not None}
    assert list(ends) == ['X', 'Y']
    whole_s = dict(expected.before)['Y']
    assert whole_s is not None
    assert ends['Y'] > whole_s, 'the packer works for the worker'
    for job, within_s in ends.items():
        ended = watch.until('job.completed', job=job)
        took_s = _worked_s(cell, moment.now_s, ended['time'])
        assert abs(took_s - within_s) < 1.0, (job, ended, expected)
    assert watch.command('in_service', component='worker', who='Ada').accepted


def _what_if_with_a_requeue_comes_true(cell: CellProcesses, recipes: Path) -> None:
    """A job was made without the worker, which is back: its rest is faster if it is made anew."""
    watch = cell.watch
    assert watch.command('out_of_service', component='worker', who='Ada').accepted
    order = by_recipe('Z')
    order.quantity = 20
    assert watch.call(QueueAdd, 'queue/add', QueueAdd.Request(orders=[order])).accepted
    watch.until('item.removed', job='Z')
    assert watch.until('task.started', job='Z', task='work')['component'] == 'packer'
    assert watch.command('in_service', component='worker', who='Ada').accepted
    anew = ask('job.requeue', By('Ada', 'test', 'the worker is back'), job='Z')
    with open_door(watch.name, 10.0) as door:
        moment = door.moment()
        assert door.ask(anew).accepted
    with closing(PlanningProcess([], [recipes])) as planning:
        expected = planning.what_if(moment, [anew])
    assert expected.refusals == ()
    ends = {entry.job: entry.ends_s for entry in expected.after if entry.ends_s is not None}
    assert list(ends)[:2] == ['Z', 'Z-rest']
    whole_s = dict(expected.before)['Z']
    assert whole_s is not None
    (note,) = (note for note in expected.notes if note.startswith('Z with Z-rest ends in '))
    assert f'without the requeue, Z ends in {whole_s:.1f} s' in note
    assert ends['Z-rest'] < whole_s, 'the worker works beside the packer'
    ended = [watch.until('job.completed', job=job) for job in ('Z', 'Z-rest')]
    assert ended[0]['seq'] < ended[1]['seq']
    for event in ended:
        took_s = _worked_s(cell, moment.now_s, event['time'])
        assert abs(took_s - ends[event['job']]) < 1.0, (event, expected)
    assert watch.until('task.started', job='Z-rest', task='work')['component'] == 'worker'


def _worked_s(cell: CellProcesses, since: float, until: float) -> float:
    """Return for how long a goal was in flight: a busy machine takes its time between goals."""
    worked, begun, running = 0.0, since, set[str]()
    for event in cell.watch.events:
        if not since <= event['time'] <= until:
            continue
        if event['event'] == 'task.started':
            begun = begun if running else event['time']
            running.add(event['goal'])
        elif event['event'] == 'task.succeeded' and event['goal'] in running:
            running.remove(event['goal'])
            worked += 0.0 if running else event['time'] - begun
    return worked + (until - begun if running else 0.0)


def _a_version_says_one_thing(cell: CellProcesses, recipes: Path) -> None:
    other = RECIPE.replace('work, do', 'worked, do')
    (recipes / 'box.yaml').write_text(other)
    change = QueueUpdate.Request(job='A', recipes=['BOX'], reason='the newest')
    response = cell.watch.call(QueueUpdate, 'queue/update', change)
    assert 'recipe BOX version 1 was another one before' in response.message
    # A script that is equal but for its version, and one that is another.
    for version, text in ((2, RECIPE), (3, other)):
        (recipes / 'box.yaml').write_text(text.replace('version: 1', f'version: {version}'))
        response = cell.watch.call(QueueUpdate, 'queue/update', change)
        assert response.accepted, response.message
        cell.watch.until('job.updated', job='A', recipe_version=version)
