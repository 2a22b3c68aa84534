"""Semantics 6.12: the first piece of a job is approved before its second item begins."""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import pytest
from fakes.commands import ControlJob
from fakes.line import THREE, Line, with_section
from fakes.operator import engineer
from fakes.virtual_run import VirtualRun
from fakes.world import World, begun

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.cell import Approval
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.report.ended_jobs import JobFold
from bt_orchestrator.view.report.isa95.job_response import response_of_record
from bt_orchestrator.view.report.item.fold import ItemFold
from bt_orchestrator.view.screen.words import job_terms

ASKED = f'first_piece: true\n{THREE}'
SORTED = 'first_piece: true\n' + with_section(
    2, '- {id: inspect, @a2, on_failure: reject}'
).replace('qty_change: -1', 'qty_change: -1, runs_for: all')
ANN = engineer('Ann', 'the test', 'measured it')


def operator(role: Role) -> By:
    return By('Bob', 'the test', 'measured it', role, Known.LOCAL_USER)


def begun_items(run: VirtualRun) -> list[str]:
    return [record['item'] for record in run.all('cycle.started', section=1)]


def waiting(text: str = ASKED, quantity: int = 3, line: Line | None = None) -> VirtualRun:
    """Return a run whose job waits for an approval."""
    run = (line or Line()).begin(text, quantity).go()
    assert run.job().piece
    return run


def test_6_12_second_item_waits_for_approval() -> None:
    run = waiting()
    assert begun_items(run) == ['J/1']
    assert run.counts()['packed'] == 1, 'the first piece goes through the whole line'
    assert run.all('job.paused') == [
        {'seq': run.all('job.paused')[0]['seq'], 'time': 0.0, 'event': 'job.paused', 'job': 'J',
         'item': 'J/1'}
    ]  # fmt: skip
    assert 'J waits for the approval of J/1' in run.waits()['section 1']
    assert run.ask(ControlJob('resume', 'J', ANN)).accepted
    run.go()
    assert run.ended
    assert run.counts()['packed'] == 3
    assert run.all('job.resumed')[0]['item'] == 'J/1'
    assert len(run.all('job.paused')) == 1


def test_6_12_the_order_asks_where_the_script_does_not() -> None:
    line = Line()
    run = VirtualRun(line.cell, line.types)
    order = Job('J', line.script(THREE), 2, {}, terms=Terms(first_piece=True))
    run.ask(AddJobs((order,)))
    run.go()
    assert begun_items(run) == ['J/1']
    assert run.all('job.queued')[0]['first_piece'] is True


def test_6_12_last_item_needs_no_approval() -> None:
    run = Line().run(ASKED, 1)
    assert run.ended
    assert not run.all('job.paused')


def test_6_12_piece_on_line_is_not_approved() -> None:
    run = Line().begin(ASKED, 2).go(until=4.0)
    answer = run.ask(ControlJob('resume', 'J', ANN))
    assert not answer.accepted
    assert answer.message == 'J/1, the first piece of J, has not left the line yet'


def test_6_12_rejected_piece_is_not_approved() -> None:
    run = waiting(SORTED, 3, Line(faults={'a2': '#1=abort'}))
    answer = run.ask(ControlJob('resume', 'J', ANN))
    assert not answer.accepted
    assert answer.message == (
        'J/1, the first piece of J, cannot be approved: it was not packed, but rejected; job '
        'another J makes another one, job stop J ends the order'
    )


def test_6_12_piece_removed_by_hand_is_not_approved() -> None:
    run = Line().begin(ASKED, 2).go(until=4.0)
    assert run.remove('J/1').accepted
    run.go()
    assert not run.ask(ControlJob('resume', 'J', ANN)).accepted
    assert run.job().piece_left == 'by_hand'


def test_6_12_a_refused_piece_is_followed_by_another() -> None:
    run = waiting(SORTED, 3, Line(faults={'a2': '#1=abort'}))
    assert run.ask(ControlJob('another', 'J', operator(Role.OPERATE))).accepted
    run.go()
    assert begun_items(run) == ['J/1', 'J/2']
    assert run.job().piece == 'J/2'
    assert run.all('job.resumed')[0] | {'seq': 0, 'time': 0} == {
        'seq': 0, 'time': 0, 'event': 'job.resumed', 'job': 'J', 'item': 'J/1', 'another': True
    }  # fmt: skip
    assert run.ask(ControlJob('resume', 'J', ANN)).accepted
    run.go()
    assert run.ended


def test_6_12_another_piece_needs_job_awaiting_approval() -> None:
    run = Line().begin(THREE, 3).go(until=2.0)
    assert run.ask(ControlJob('pause', 'J', ANN)).accepted
    answer = run.ask(ControlJob('another', 'J', ANN))
    assert answer.message == 'J waits for no approval of a first piece'


def test_6_12_a_stop_refuses_it_and_ends_the_order() -> None:
    run = waiting()
    assert run.ask(ControlJob('stop', 'J', ANN)).accepted
    run.go()
    assert run.ended
    assert run.all('job.stopping')[0]['item'] == 'J/1'
    assert begun_items(run) == ['J/1']


def test_6_12_an_abort_ends_the_wait() -> None:
    run = waiting()
    assert run.ask(ControlJob('abort', 'J', ANN)).accepted
    run.go()
    assert run.ended


@pytest.mark.parametrize(
    ('who', 'role', 'may'),
    [
        (Approval.ENGINEER, Role.OPERATE, False),
        (Approval.ENGINEER, Role.MES, False),
        (Approval.ENGINEER, Role.ENGINEER, True),
        (Approval.OPERATE, Role.OPERATE, True),
        (Approval.OPERATE, Role.ENGINEER, True),
        (Approval.OPERATE, Role.MES, False),
    ],
)
def test_6_12_cell_file_sets_approving_role(who: Approval, role: Role, may: bool) -> None:
    line = Line()
    line.cell = replace(line.cell, first_piece=who)
    run = waiting(line=line)
    answer = run.ask(ControlJob('resume', 'J', operator(role)))
    assert answer.accepted is may
    if not may:
        assert 'J waits for the approval of J/1, its first piece, by engineer' in answer.message
        assert run.job().piece == 'J/1'


def test_6_12_operator_resumes_job_paused_by_person() -> None:
    run = Line().begin(THREE, 3).go(until=2.0)
    for verb in ('pause', 'resume'):
        assert run.ask(ControlJob(verb, 'J', operator(Role.OPERATE))).accepted


def test_6_12_next_job_waits_while_earlier_one_continues() -> None:
    line = Line()
    run = line.begin(THREE, 2)
    for name, text in (('K', ASKED), ('L', THREE)):
        run.submit(name, line.script(text), 2)
    run.go()
    assert run.counts('J')['packed'] == 2
    assert begun_items(run) == ['J/1', 'J/2', 'K/1']


def test_6_12_automatic_waits_for_nobody() -> None:
    line = Line()
    line.cell = replace(line.cell, first_piece=Approval.AUTOMATIC)
    assert line.run(ASKED, 3).ended


def test_6_12_the_status_says_what_is_waited_for() -> None:
    line = Line()
    simulation = Simulation(line.cell, line.types, MemoryStore())
    simulation.submit([Job('J', line.script(ASKED), 2, {})])
    simulation.run()
    (job,) = simulation.status().jobs
    assert (job.first_piece, job.first_piece_state) == ('J/1', 'packed')
    words = job_terms(job)
    assert words == ', waits for the approval of J/1 (packed)'
    assert job.end_unknown == 'J waits for the approval of J/1'


def test_6_12_record_of_item_and_job_tell_the_decision() -> None:
    run = waiting(SORTED, 4, Line(faults={'a2': '#1=abort'}))
    run.ask(ControlJob('another', 'J', ANN))
    run.go()
    run.ask(ControlJob('resume', 'J', ANN))
    run.go()
    assert run.ended
    events = list(run.store.read())
    fold_of_jobs = JobFold()
    for event in events:
        fold_of_jobs.follow(event)
    job = fold_of_jobs.jobs['J']
    assert (job.first_piece, job.first_piece_state) == ('J/2', 'approved')
    response = response_of_record(job)
    assert response is not None
    values = {datum.id: datum.value for datum in response.data}
    assert (values['FirstPiece'], values['FirstPieceState']) == ('J/2', 'approved')
    for item, state, word in (('J/1', 'refused', 'another'), ('J/2', 'approved', 'resume')):
        fold = ItemFold(item, 'J')
        for event in events:
            fold.follow(event)
        assert fold.history.first_piece == state
        (decision,) = fold.history.decisions
        assert (decision.what, decision.who, decision.reason) == (word, 'Ann', 'measured it')


def killed(line: Line, settles: int) -> tuple[World, Orchestrator]:
    world = World(line.cell)
    first = begun(world, line.script(ASKED), 2)
    world.go(first, settles)
    first.close()
    second = world.orchestrator()
    world.go(second)
    return world, second


def test_6_12_killed_cell_awaits_one_piece_after_any_settle() -> None:
    line, kills = Line(), 0
    whole = World(line.cell)
    whole.go(begun(whole, line.script(ASKED), 2))
    most = len(list(whole.store.read()))
    for settles in count(1):
        world, second = killed(line, settles)
        paused = world.events(e.JobPaused)
        assert [(event.job, event.item) for event in paused] == [('J', 'J/1')], settles  # type: ignore[attr-defined]
        assert second.ask(ControlJob('resume', 'J', ANN)).accepted
        world.go(second)
        assert not second.state.jobs
        assert second.state.ended['J'].progress.packed == 2
        assert len(world.events(e.JobPaused)) == 1
        second.close()
        kills += 1
        if settles > most:
            break
    assert kills > 10
