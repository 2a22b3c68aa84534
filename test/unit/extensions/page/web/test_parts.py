"""The parts of the page say what the status says, at every moment of a run."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from fakes.line import THREE, TYPES, Line, with_initialization, with_section
from fakes.page_parts import NODE, marks, page_parts, scripts_of, status_of
from fakes.statuses import hold
from fakes.virtual_run import VirtualRun

from bt_orchestrator.engine.runtime.overview import description_of
from bt_orchestrator.extensions.page.web.parts import parts_of
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.status import CellDescription, Leadership, StandbyStatus
from bt_orchestrator.model.status_words import task_label
from bt_orchestrator.model.words import sentence

LISTED = with_section(
    2,
    """
    - {id: turn, @a2}
    - parallel: [{id: left, @b2}, [{id: right, @arm}, {id: after, @arm.TASK_B}]]
    - {id: late, @a2.TASK_B, requires_conveyor: false}
    """,
)

RUNNING, ENDED = JobWord.RUNNING, JobWord.ENDED

KINDS = {'cell', 'now', 'belt', 'flags', 'line', 'why', 'section', 'hold', 'job', 'component'}


def check_parts(run: VirtualRun) -> None:
    """Compare every part with the status of the same moment."""
    status, parts = status_of(run), page_parts(run)
    assert {key.partition('/')[0] for key in parts} <= KINDS
    assert json.loads(json.dumps(parts, allow_nan=False)) == parts
    assert parts == page_parts(run), 'two looks at one moment'
    cell = parts['cell']
    assert (cell['state'], cell['since']) == (status.state.value, status.state_since)
    assert cell['sections'] == [row.number for row in status.sections]
    assert cell['holds'] == [hold.id for hold in status.holds], 'as they were raised'
    assert cell['jobs'] == [job.id for job in status.jobs]
    assert parts['now']['seq'] == status.seq
    assert parts['belt']['moving'] == status.belt.moving
    for section in status.sections:
        part = parts[f'section/{section.number}']
        assert {wait['words'] for wait in part['waits']} == {str(row) for row in section.waits}
        is_ordinary = [wait['is_ordinary'] for wait in part['waits']]
        assert is_ordinary == sorted(is_ordinary), 'what is not normal goes first'
        at_work = {task['id'] for task in part['tasks'] if task['mark'] == 'running'}
        assert at_work == {task.id for task in section.running}
        over = {'done', 'marked_done', 'skipped', 'continued', 'rejected', 'aborted'}
        ended = {task['id']: task['mark'] for task in part['tasks'] if task['mark'] in over}
        left = section.finished.passed if section.finished and not section.item else ()
        assert ended == {task.id: task.end.value for task in (*section.passed, *left)}
        done = part['finished'] and {row['id']: row['mark'] for row in part['finished']['tasks']}
        assert (done or {}) == done_in_this_beat(run, section.number)
        slot = part['slot']
        assert (slot and slot['id']) == (section.slot and section.slot.id)
    for job in status.jobs:
        part = parts[f'job/{job.id}']
        assert (part['left'], part['on_line']) == (job.left, job.on_line)
        assert part['is_over'] == (job.ended_at is not None)


def done_in_this_beat(run: VirtualRun, section: int) -> dict[str, str]:
    """Return the tasks of the last cycle that ended since the belt moved, by the journal."""
    ended: dict[str, str] = {}
    since: list[dict[str, Any]] = []
    for record in run.records:
        since.append(record)
        if record['event'] == 'belt.indexed':
            ended, since = {}, []
        if record['event'] == 'cycle.completed' and record['section'] == section:
            ended = {
                entry['task']: _ENDS[entry['event']]
                for entry in run.records[: record['seq']]
                if entry.get('item') == record['item']
                and entry.get('section') == section
                and entry['event'] in _ENDS
            }
    return ended if any(entry.slot for entry in run.state.sections.values()) else {}


_ENDS = {'task.succeeded': 'done', 'task.skipped': 'skipped', 'task.marked_done': 'marked_done'}


def test_waiting_section_keeps_finished_tasks() -> None:
    run = Line(seconds={'a1': 4.0}).begin(THREE, 3).go(until=7.5)
    assert marks(page_parts(run), 2) == [('work', 'done')]
    assert page_parts(run)['section/2']['finished']['item'] == 'J/1'
    run.go(until=12.5)
    assert page_parts(run)['section/2']['slot']['id'] == 'J/2'
    assert marks(page_parts(run), 2) == [('work', 'running')]


def test_next_and_finished_cycle_are_both_shown() -> None:
    pick = '{id: pick, @b1, requires_conveyor: false}'
    text = with_section(1, f'[{pick}, {{id: place, @a1, qty_change: 1}}]')
    run = Line(seconds={'a2': 9.0}).begin(text, 3).go(until=8.0)
    part = page_parts(run)['section/1']
    assert marks(page_parts(run), 1) == [('pick', 'done'), ('place', 'waiting')]
    assert part['item']['id'] == 'J/3'
    assert part['finished']['item'] == part['slot']['id'] == 'J/2'
    assert {task['mark'] for task in part['finished']['tasks']} == {'done'}


@pytest.mark.parametrize('sections', [3, 5, 9])
def test_parts_match_status_throughout_run(sections: int) -> None:
    run = Line(sections).begin(LISTED, 4)
    while not run.ended:
        check_parts(run)
        due = run.sim.clock.next_deadline()
        assert due is not None
        run.go(until=due)
    check_parts(run)


def test_two_jobs_with_two_scripts_share_the_line() -> None:
    line = Line(3)
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(THREE, 'one'), 2)
    run.submit('K', line.script(LISTED, 'two'), 2)
    lists = set()
    while not run.ended:
        check_parts(run)
        lists.add(tuple(id_ for id_, _ in marks(page_parts(run), 2)))
        due = run.sim.clock.next_deadline()
        assert due is not None
        run.go(until=due)
    assert lists == {('work',), ('turn', 'left', 'right', 'after', 'late')}


def test_section_tasks_have_step_and_track() -> None:
    run = Line(3).begin(LISTED)
    run.go(until=4.5)
    tasks = page_parts(run)['section/2']['tasks']
    rows = [(task['id'], task['step'], task['track'], task['mark']) for task in tasks]
    assert rows == [
        ('turn', 1, 1, 'done'),
        ('left', 2, 1, 'running'),
        ('right', 2, 2, 'running'),
        ('after', 2, 2, 'new'),
        ('late', 3, 1, 'new'),
    ]
    left = tasks[1]
    assert (left['component'], left['attempt'], left['started']) == ('b2', 1, 4.0)
    assert left['expected_s'] == 1.0
    assert [task['requires_conveyor'] for task in tasks] == [True, True, True, True, False]


def test_section_without_cycle_shows_next_job() -> None:
    run = Line(3).begin(LISTED)
    run.go(until=0.5)
    assert marks(page_parts(run), 2) == [
        (task, 'new') for task in ('turn', 'left', 'right', 'after', 'late')
    ]


def test_held_task_shows_reason_and_answers() -> None:
    run = Line(3, faults={'a2': 'TASK_A=abort'}).begin()
    run.go()
    parts = page_parts(run)
    assert marks(parts, 2) == [('work', 'held')]
    (hold,) = parts['cell']['holds']
    assert parts['section/2']['holds'] == [hold]
    part = parts[f'hold/{hold}']
    assert (part['task'], part['item'], part['component']) == ('work', 'J/1', 'a2')
    assert (part['attempt'], part['attempts'], part['is_pause']) == (1, 1, False)
    (task,) = parts['section/2']['tasks']
    assert task['reason'].startswith(part['reason'])
    assert (task['hold'], task['waits']) == (hold, [])
    assert parts['cell']['state_kind'] == 'trouble'


def test_waiting_task_names_its_cause_as_data() -> None:
    run = Line(3, seconds={'a1': 9.0}).begin(THREE, 3)
    run.go(until=1.0)
    assert run.service('a2', out=True).accepted
    run.go(until=15.0)
    (task,) = page_parts(run)['section/2']['tasks']
    assert (task['mark'], task['hold']) == ('waiting', '')
    assert [(wait['kind'], wait['name']) for wait in task['waits']] == [('out_of_service', 'a2')]


def test_initialization_tasks_stand_with_their_job() -> None:
    text = with_initialization('[{id: warm, @a1.PREPARE}, {id: light, @lamp.PREPARE}]')
    line = Line(3)
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(text))
    run.submit('K', line.script(text))
    run.go(until=0.5)
    parts = page_parts(run)
    assert [(task['id'], task['mark']) for task in parts['job/J']['tasks']] == [
        ('warm', 'running'),
        ('light', 'running'),
    ]
    assert {task['mark'] for task in parts['job/K']['tasks']} == {'new'}


def test_passing_time_changes_only_now_part() -> None:
    run = Line(3, seconds={'a1': 50.0}).begin(THREE, 3)
    run.go(until=1.0)
    before = page_parts(run)
    run.sim.clock.call_at(20.0, lambda: None)
    run.go(until=20.0)
    after = page_parts(run)
    assert {key for key in after if before.get(key) != after[key]} == {'now'}


def test_task_is_late_above_150_percent() -> None:
    run = Line(3, seconds={'a1': 50.0}).begin(THREE, 3)
    run.go(until=1.0)
    (running,) = status_of(run).sections[0].running
    assert running.expected_s == 50.0
    assert late_after(run, 75.0) == []
    assert late_after(run, 75.1) == [running.id]


def late_after(run: VirtualRun, elapsed_s: float) -> list[str]:
    """Return the tasks that are shown as late so long after the run began."""
    later = replace(status_of(run), stamp=elapsed_s)
    parts: Any = parts_of(later, description_of(run.state.cell, TYPES), scripts_of(run), NODE)
    tasks = [task for key in parts for task in parts[key].get('tasks', ())]
    return [task['id'] for task in tasks if task['is_late']]


@pytest.mark.parametrize(
    ('due', 'ends_in', 'state', 'late_s', 'is_overdue'),
    [
        (None, 500.0, RUNNING, 0, False),
        (1000.0, 900.0, RUNNING, 0, False),
        (1000.0, 901.0, RUNNING, 60, False),
        (1000.0, 1080.0, RUNNING, 180, False),
        (50.0, None, RUNNING, 60, True),
        (50.0, 200.0, RUNNING, 300, True),
        (50.0, 200.0, ENDED, 0, False),
    ],
)
def test_job_lateness_uses_expected_end_or_now(
    due: float | None, ends_in: float | None, state: JobWord, late_s: float, is_overdue: bool
) -> None:
    status = replace(status_of(Line().begin(LISTED, 1)), stamp=100.0)
    (job,) = status.jobs
    job = replace(job, due=due, expected_end_s=ends_in, state=state)
    parts: Any = parts_of(replace(status, jobs=(job,)), CellDescription('', 0, ''), {}, NODE)[
        f'job/{job.id}'
    ]
    assert (parts['late_s'], parts['is_overdue']) == (late_s, is_overdue)


def test_unknown_script_still_gives_all_parts() -> None:
    from bt_orchestrator.engine.runtime.overview import description_of
    from bt_orchestrator.extensions.page.web.parts import parts_of

    run = Line(3).begin()
    run.go(until=0.5)
    parts = parts_of(status_of(run), description_of(run.state.cell, TYPES), {}, '/node')
    section = parts['section/1']
    assert isinstance(section, dict)
    assert section['tasks'] == []


@pytest.mark.parametrize(
    ('task', 'name', 'label'),
    [
        ('weigh', 'TASK_A', 'weigh'),
        ('4.2', 'TASK_A', '4.2 TASK_A'),
        ('init.1', 'HOME', 'init.1 HOME'),
        ('', 'TASK_A', 'TASK_A'),
    ],
)
def test_task_label_follows_script_name(task: str, name: str, label: str) -> None:
    assert task_label(task, name) == label


def test_a_wait_names_its_hold_in_each_language() -> None:
    run = Line(3, faults={'a2': '#1=abort'}).begin(THREE, 3)
    run.go()
    parts = page_parts(run)
    sentences = [wait['said'] for wait in parts['section/1']['waits'] if wait['kind'] == 'hold']
    assert sentences == [
        {
            'en': 'waiting for an answer to hold 1 (work: the controller gave up)',
            'de': 'wartet auf Antwort auf Störung 1 (work: der Controller hat abgebrochen)',
        }
    ]
    links = [link for chain in parts['why']['chains'] for link in chain['links']]
    assert sentences[0] in [link['said'] for link in links]


def test_holds_keep_order_after_clock_step() -> None:
    run = Line().begin(LISTED, 1)
    status = replace(status_of(run), holds=(hold('1', since=3600.0), hold('2', since=60.0)))
    parts: Any = parts_of(status, description_of(run.state.cell, TYPES), scripts_of(run), NODE)
    assert parts['cell']['holds'] == ['1', '2']


def test_a_contest_is_said_in_each_language() -> None:
    run = Line(3).begin(THREE, 3).go(until=1.0)
    run.state.contests['a2'] = Contest(servers=('/here', '/there'))
    sentences = page_parts(run)['component/a2']['contested_said']
    assert sentences['en'].startswith('2 servers of /a2/do: /here, /there')
    assert sentences['de'].startswith('2 Server für /a2/do: /here, /there')


def test_unready_safety_input_is_explained_in_every_language() -> None:
    run = Line().begin(quantity=1).go(until=1.0)
    run.state.unsafe = sentence('unsafe_unpublished')
    cell = page_parts(run)['cell']
    assert cell['safety_said'] == {'en': 'it has no publisher', 'de': 'er hat keinen Publisher'}
    assert 'safety_words' not in cell


def test_leader_and_standbys_are_told_in_each_language() -> None:
    run = Line().begin(quantity=1).go(until=1.0)
    assert page_parts(run)['cell']['leadership'] is None
    blind = StandbyStatus('m3', 8, sentence('standby_servers', actions='/a2/do'), 90)
    status = replace(
        status_of(run), leadership=Leadership('m1', 4, 7, (StandbyStatus('m2', 5, '', 91), blind))
    )
    parts: Any = parts_of(status, description_of(run.state.cell, TYPES), scripts_of(run), NODE)
    leader = parts['cell']['leadership']
    assert (leader['host'], leader['process'], leader['epoch']) == ('m1', 4, 7)
    ready, other = leader['standbys']
    assert (ready['host'], set(ready['said'].values())) == ('m2', {''})
    assert other['said']['en'] == 'it does not see the servers of /a2/do'
    assert other['said']['de'] == 'er sieht die Server von /a2/do nicht'
    assert 'seq' not in ready, 'it changes all the time, and every browser would hear of it'
