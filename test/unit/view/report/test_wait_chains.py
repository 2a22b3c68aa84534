"""From what waits to the root cause."""

from __future__ import annotations

import pytest
from fakes.line import Line, with_initialization, with_section
from fakes.page_parts import page_parts, root_of, way_of
from fakes.statuses import section, status

from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import BeltStatus, SectionStatus
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.view.report.wait_chains import causes, chains


def test_belt_waits_for_section_at_held_component() -> None:
    text = with_section(2, '[{id: work, @arm}]')
    text = text.replace('3: [{id: pack', '3: [{id: look, @arm.TASK_B}, {id: pack')
    run = Line(3, faults={'arm': 'TASK_A=abort:2'}).begin(text, 3)
    run.go()
    parts = page_parts(run)
    (hold,) = parts['cell']['holds']
    assert root_of(parts, 'belt') == (f'hold/{hold}', 'hold')
    assert way_of(parts, 'section/2') == [f'hold/{hold}']


def test_section_waits_for_component_working_elsewhere() -> None:
    text = with_section(2, '[{id: work, @arm}]')
    text = text.replace('3: [{id: pack', '3: [{id: look, @arm.TASK_B}, {id: pack')
    run = Line(3, seconds={'arm': 10.0}).begin(text, 3)
    run.go(until=9.0)
    while not page_parts(run)['component/arm']['task'] or not _waits_for_arm(run):
        due = run.sim.clock.next_deadline()
        assert due is not None
        run.go(until=due)
    parts = page_parts(run)
    waiting = next(
        f'section/{n}'
        for n in (2, 3)
        if any(wait['kind'] == 'component' for wait in parts[f'section/{n}']['waits'])
    )
    assert root_of(parts, waiting) == ('component/arm', 'task')


def _waits_for_arm(run: object) -> bool:
    parts = page_parts(run)  # type: ignore[arg-type]
    kinds = [wait['kind'] for n in (2, 3) for wait in parts[f'section/{n}']['waits']]
    return 'component' in kinds


def test_a_source_waits_for_initialization_that_is_held() -> None:
    text = with_initialization('[{id: warm, @a1.PREPARE}]')
    run = Line(3, faults={'a1': 'PREPARE=abort'}).begin(text)
    run.go()
    parts = page_parts(run)
    (hold,) = parts['cell']['holds']
    assert root_of(parts, 'section/1') == (f'hold/{hold}', 'hold')


def test_unready_component_is_the_cause() -> None:
    run = Line(3, topics=('a2',), faults={'a2': '#0=not_ready'}).begin()
    run.go()
    parts = page_parts(run)
    assert root_of(parts, 'section/2') == ('component/a2', 'readiness')
    assert root_of(parts, 'belt') == ('component/a2', 'readiness')
    assert way_of(parts, 'belt') == ['section/2', 'component/a2', '']


def test_nothing_is_said_twice_in_a_row() -> None:
    run = Line(3, seconds={'a1': 10.0}).begin()
    run.go(until=5.0)
    (chain,) = (entry for entry in page_parts(run)['why']['chains'] if entry['part'] == 'belt')
    assert [link['words'] for link in chain['links']] == [
        'waiting for section 1 to finish with J/1',
        'a1 works on place',
    ]
    assert chain['root']['part'] == 'component/a1'


def test_links_repeat_waits_and_root_says_more() -> None:
    run = Line(3, faults={'a2': 'TASK_A=abort'}).run(quantity=2)
    parts = page_parts(run)
    (chain,) = (entry for entry in parts['why']['chains'] if entry['part'] == 'section/2')
    (wait,) = parts['section/2']['waits']
    (link,) = chain['links']
    assert link['words'] == wait['words'] == 'waiting for an answer to hold 1 (work: aborted)'
    assert chain['root']['words'].startswith('hold 1: section 2, work (TASK_A) of J/1 at a2')


def test_zone_wait_leads_to_occupying_section() -> None:
    text = 'zones: {table: [work, pack]}\n' + with_section(2, '[{id: work, @a2}]')
    run = Line(3, faults={'a3': '#1=abort'}).run(text, 2)
    parts = page_parts(run)
    (hold,) = parts['cell']['holds']
    (wait,) = (wait for wait in parts['section/2']['waits'] if wait['kind'] == 'zone')
    assert (wait['name'], wait['sections'], wait['task']) == ('table', [3], 'pack')
    assert way_of(parts, 'section/2') == ['section/3', f'hold/{hold}']


def test_busy_component_names_task_and_section() -> None:
    text = with_section(2, '[{id: work, @arm}]')
    text = text.replace('3: [{id: pack', '3: [{id: look, @arm.TASK_B}, {id: pack')
    run = Line(3, faults={'arm': 'TASK_B#1=abort'}).run(text, 2)
    (wait,) = (w for w in page_parts(run)['section/2']['waits'] if w['kind'] == 'component')
    assert (wait['name'], wait['sections'], wait['task']) == ('arm', [3], 'look')


def test_each_link_begins_where_the_one_before_leads() -> None:
    run = Line(5, faults={'a3': 'TASK_A=abort'}).begin(quantity=4)
    run.go()
    for chain in page_parts(run)['why']['chains']:
        here = chain['part']
        for link in chain['links']:
            assert link['part'] == here
            here = link['to']


def test_circular_waits_end_the_walk() -> None:
    turn = Wait('waiting for section 1 to finish with WO-1/1', WaitKind.TURN, sections=(1,))
    belt = Wait('waiting for the belt to move', WaitKind.BELT)
    walks = chains(
        status(
            belt=BeltStatus(waits=(turn,)),
            sections=(SectionStatus(1, waits=(belt,)), section(2)),
        )
    )
    ways = {chain.part: [link.to for link in chain.links] for chain in walks}
    assert ways == {'section/1': ['belt', 'section/1'], 'belt': ['section/1', 'belt']}


def test_operator_action_precedes_waiting_for_time() -> None:
    working = Wait('waiting for section 1 to finish with WO-1/2', WaitKind.TURN, sections=(1, 2))
    paused = Wait('waiting for WO-1 to be resumed', WaitKind.PAUSE, 'WO-1')
    walks = chains(
        status(
            belt=BeltStatus(waits=(working,)),
            sections=(
                SectionStatus(1, waits=(Wait('waiting for a job', WaitKind.JOB),)),
                SectionStatus(2, waits=(paused,)),
            ),
        )
    )
    (root,) = (chain.root for chain in walks if chain.part == 'belt')
    assert (root.part, root.kind) == ('job/WO-1', 'pause')


def test_operator_causes_come_first_with_waiting_parts() -> None:
    paused = Wait('waiting for WO-1 to be resumed', WaitKind.PAUSE, 'WO-1')
    nothing = Wait('waiting for a job', WaitKind.JOB)
    turn = Wait('waiting for section 3 to finish with WO-1/2', WaitKind.TURN, sections=(3,))
    ordered = causes(
        chains(
            status(
                belt=BeltStatus(waits=(turn,)),
                sections=(
                    SectionStatus(1, waits=(nothing,)),
                    SectionStatus(2, waits=(nothing,)),
                    SectionStatus(3, waits=(paused,)),
                ),
            )
        ),
        PackmlState.EXECUTE,
    )
    assert [(cause.root.kind, cause.is_ordinary, cause.waiting) for cause in ordered] == [
        ('pause', False, ('section/3', 'belt')),
        ('job', True, ('section/1',)),
        ('job', True, ('section/2',)),
    ]


def test_long_running_task_is_ordinary_cause() -> None:
    run = Line(3, seconds={'a1': 10.0}).begin()
    run.go(until=5.0)
    causes_now = page_parts(run)['why']['causes']
    (works,) = (cause for cause in causes_now if cause['part'] == 'component/a1')
    assert works['is_ordinary']
    assert 'belt' in works['waiting']


@pytest.mark.parametrize(
    ('state', 'is_ordinary'),
    [
        (PackmlState.COMPLETE, True),
        (PackmlState.IDLE, True),
        (PackmlState.STOPPED, True),
        (PackmlState.ABORTED, False),
    ],
)
def test_cell_at_rest_is_ordinary_unless_aborted(state: PackmlState, is_ordinary: bool) -> None:
    wait = Wait(f'the cell is {state.value}', WaitKind.CELL_STATE)
    at_rest = status(state=state, sections=(SectionStatus(1, waits=(wait,)),))
    (cause,) = causes(chains(at_rest), state)
    assert cause.is_ordinary is is_ordinary
