"""How a line stands at each point of a virtual run, as watchers are told."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.commands import Abort
from fakes.line import THREE, TYPES, Line, with_section
from fakes.line_picture import DrawnLine
from fakes.virtual_run import VirtualRun

from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.engine.runtime.overview import Overview, description_of
from bt_orchestrator.model.cell import SafetyInput
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.state import End, PassedTask
from bt_orchestrator.model.status import CellStatus, FinishedCycle, ItemStatus
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.model.words import Words, sentence
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.status_marks import line_state
from bt_orchestrator.view.screen import words

SCRIPT = """
params: {off: {type: bool, default: true}}
initialization: [{id: home, task: PREPARE, action: /b2/do}]
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - {id: look, @a2, %s}
    - {id: next, @a2.TASK_B}
    - {id: photo, @b2, runs_for: all}
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""


def at_work(line: Line, options: str, answer: str = '') -> VirtualRun:
    """Run until section 2 takes the photo of its first item, or the line is held."""
    run = line.begin(SCRIPT % options, quantity=3).go(until=5.0)
    if answer:
        run.answer(answer)
        run.go(until=5.5)
    return run


def passed(status: CellStatus) -> dict[str, tuple[str, str]]:
    return {task.id: (task.end.value, task.reason) for task in status.sections[1].passed}


def slot(status: CellStatus, section: int) -> ItemStatus:
    item_status = status.sections[section - 1].slot
    assert item_status is not None
    return item_status


def item(status: CellStatus, section: int) -> ItemStatus:
    """Return the item of the cycle in hand."""
    item_status = status.sections[section - 1].item
    assert item_status is not None
    return item_status


@pytest.mark.parametrize(
    ('options', 'answer', 'look', 'word'),
    [
        ('on_failure: reject', '', ('rejected', 'task_result_false'), 'failed, item rejected'),
        ('on_failure: continue', '', ('continued', 'task_result_false'), 'failed, continued'),
        ('on_failure: abort_job', '', ('aborted', 'task_result_false'), 'failed, job aborted'),
        ('on_failure: hold', 'reject', ('rejected', 'task_result_false'), 'failed, item rejected'),
        ('on_failure: hold', 'mark_done', ('marked_done', 'task_result_false'), 'marked done'),
        ('on_failure: hold', 'skip', ('skipped', 'Ann decided skip: it looked so'), 'skipped'),
        ('unless: "${params.off}"', '', ('skipped', 'unless ${params.off}'), 'skipped'),
        ('retries: 1', '', ('done', ''), 'done'),
    ],
)
def test_passed_task_says_how_it_ended(
    options: str, answer: str, look: tuple[str, str], word: str
) -> None:
    line = Line(faults={'a2': 'TASK_A#1=false'}, seconds={'b2': 3.0})
    run = at_work(line, options, answer)
    if 'retries' in options:
        run.go(until=6.5)
    status = run.sim.status()
    ends = passed(status)
    assert ends['look'][0] == look[0]
    assert ends['look'][1].startswith(look[1])
    assert ('look' in status.sections[1].failed) is (
        look[0] in ('rejected', 'continued', 'aborted')
    )

    state = line_state(status, run.state.script('J'), line.cell)
    picture = DrawnLine(draw_line(run.state.script('J'), line.cell, state).svg)
    assert picture.words('task.look')[0].endswith(word)


def test_a_rejected_item_is_told_wherever_it_stands() -> None:
    line = Line(faults={'a2': 'TASK_A#1=false'}, seconds={'b2': 3.0})
    run = at_work(line, 'on_failure: reject')
    status = run.sim.status()
    assert (slot(status, 2).rejected, item(status, 2).rejected) == (True, True)
    assert passed(status)['next'] == ('skipped', 'rejected item')
    assert words.fate(slot(status, 2)) == 'rejected'

    status = run.go(until=9.5).sim.status()
    assert status.sections[0].slot is None
    assert (slot(status, 2).id, slot(status, 3).id) == ('J/2', 'J/1')
    assert (slot(status, 2).rejected, slot(status, 3).rejected) == (False, True)


def test_a_nonconforming_item_names_the_tasks() -> None:
    line = Line(faults={'a2': 'TASK_A#1=false'}, seconds={'b2': 3.0})
    status = at_work(line, 'on_failure: continue').sim.status()
    assert slot(status, 2).nonconforming == item(status, 2).nonconforming == ('look',)


def test_empty_position_is_reported_in_cycle() -> None:
    line = Line(seconds={'b2': 3.0})
    run = at_work(line, 'timeout: none')
    run.remove('J/1')
    status = run.sim.status()
    assert (slot(status, 2).present, item(status, 2).present) == (False, False)


def test_initialization_that_ended_is_told() -> None:
    run = at_work(Line(faults={'b2': 'PREPARE=false'}), 'timeout: none')
    run.answer('mark_done')
    (job,) = run.sim.status().jobs
    assert job.passed == (PassedTask('home', End.MARKED_DONE, 'task_result_false'),)


# --- work of this beat that is finished -------------------------------------------------------


def test_finished_work_survives_abort_and_restart() -> None:
    line = Line(seconds={'a1': 4.0})
    run = line.begin(THREE, 3).go(until=7.5)
    done = FinishedCycle('J', 'J/1', (PassedTask('work', End.DONE),))
    assert run.sim.status().sections[1].finished == done
    run.command(Abort)
    assert run.go(until=8.0).sim.status().sections[1].finished == done
    again = Simulation(line.cell, line.types, run.store)
    assert again.status().sections[1].finished == done


def test_drawing_and_terminal_tell_the_finished_work() -> None:
    line = Line(faults={'a2': '#1=abort'}, seconds={'a1': 4.0})
    run = line.begin(with_section(2, '[{id: look, @a2, on_failure: continue}]'), 3).go(until=7.5)
    status, script = run.sim.status(), run.state.script('J')
    picture = draw_line(script, line.cell, line_state(status, script, line.cell))
    assert DrawnLine(picture.svg).words('task.look')[0].endswith('failed, continued')
    assert 'done with J/1' in picture.svg
    (row,) = (line for line in words.status_lines(status, None) if 'section 2' in line)
    assert (
        row.split('J/1', 1)[1]
        .strip()
        .startswith('nonconforming (look); done with J/1 (look failed); waiting')
    )


def test_an_empty_belt_has_no_finished_work() -> None:
    run = Line().begin(THREE, 1).go()
    assert run.state.sections[3].finished is not None
    assert [section.finished for section in run.sim.status().sections] == [None, None, None]


# --- goals in flight ------------------------------------------------------------------------


def test_running_goal_is_reported_where_it_runs() -> None:
    line = Line(seconds={'b2': 3.0})
    run = line.begin(SCRIPT % 'timeout: none', quantity=3).go(until=0.5)
    (job,) = run.sim.status().jobs
    assert [(task.id, task.component, task.expected_s) for task in job.running] == [
        ('home', 'b2', 3.0)
    ]
    assert job.initialization == ('home',)
    run.go(until=2.0)
    belt = run.sim.status().belt
    assert belt.moving
    assert [(task.id, task.name, task.component) for task in belt.running] == [
        ('index', 'MOVE_ONE_INDEX', 'conveyor')
    ]
    run.go(until=6.0)
    status = run.sim.status()
    assert [task.id for task in status.sections[1].running] == ['photo']
    assert not status.belt.running
    assert not status.jobs[0].running


def test_expected_task_duration_follows_recent_runs() -> None:
    line = Line(seconds={'a1': 4.0})
    durations = ObservedDurations()
    run = VirtualRun(line.cell, line.types, duration=lambda _: 7.0)
    overview = Overview(run.sim.orchestrator, durations)

    def expected_s() -> float | None:
        (task,) = overview.status(run.now).sections[0].running
        return task.expected_s

    run.submit('J', line.script(THREE), 2)
    run.go(until=1.0)
    assert expected_s() == 4.0, 'nominal'
    run.go(until=15.0)
    durations.publish(list(run.store.read()))
    assert expected_s() == 7.0


def test_waits_say_which_components_would_work_otherwise() -> None:
    status = Line().begin(quantity=2).go(until=0.5).sim.status()
    first, second = status.sections[:2]
    assert not first.waits
    (wait,) = second.waits
    assert (wait.kind, wait.reason) == (WaitKind.ITEM, 'waiting for an item')
    assert [belt_wait.kind for belt_wait in status.belt.waits] == [WaitKind.TURN]


def test_a_cell_is_described_as_its_file_says() -> None:
    line = Line(seconds={'a1': 4.0})
    details = description_of(line.cell, TYPES)
    assert (details.cell, details.sections, details.conveyor) == ('test_line', 3, 'conveyor')
    arm = next(component for component in details.components if component.name == 'arm')
    assert (arm.action, arm.sections) == ('/arm/do', (2, 3))
    a1 = next(component for component in details.components if component.name == 'a1')
    assert (a1.durations_s['TASK_B'], a1.default_duration_s) == (4.0, 1.0)
    assert a1.tasks == ('PREPARE', 'TASK_A', 'TASK_B', 'TASK_C')
    assert a1.goal_fields == {'special_argument_1': 'string', 'special_argument_2': 'float64'}


def safe_run() -> VirtualRun:
    line = Line(3)
    safety = SafetyInput('/safety/ok', 'std_msgs/msg/Bool', 'data', (True,))
    return VirtualRun(replace(line.cell, safety=safety), line.types)


def test_unready_safety_input_is_explained_by_facts() -> None:
    run = safe_run()
    overview = Overview(run.sim.orchestrator)

    def told(unsafe: str) -> Words | None:
        run.sim.gateway.say_of_safety(unsafe)
        run.sim.orchestrator.settle()
        return overview.status(run.now).safety_words

    run.go()
    assert told('') is None
    assert told(sentence('unsafe_value', value='False')) == Words(
        'unsafe_value', {'value': 'False'}
    )
    (hold,) = overview.status(run.now).holds
    assert [fact.kind for fact in hold.message_words] == ['unsafe']
    assert overview.status(run.now).stop_words == Words('hold', {'hold': hold.id})
    told('')
    assert told('as an older node said') is None
    assert overview.status(run.now).safety == 'as an older node said'
    told('')
    assert told(sentence('unsafe_value', value='a; b')) is None, 'half of it would be wrong'


def test_safety_abort_is_reported_as_facts() -> None:
    run = safe_run()
    run.submit('J', Line(3).script(THREE), 1)
    run.go(until=1.0)
    run.sim.gateway.say_of_safety(sentence('unsafe_silent', seconds='0.5'))
    run.sim.orchestrator.settle()
    status = Overview(run.sim.orchestrator).status(run.now)
    assert status.stop_words == Words('unsafe', {'words': 'no message for 0.5 s'})


def test_a_contest_is_told_as_facts() -> None:
    run = Line(3).begin(THREE)
    run.sim.gateway.bring_in('a2', Contest(('/one', '/two')))
    run.sim.orchestrator.settle()
    status = Overview(run.sim.orchestrator).status(run.now)
    contests = {component.name: component.contested_words for component in status.components}
    assert contests['a2'] is not None
    assert contests['a2'].kind == 'several_servers'
    assert contests['a2'].values['servers'] == '/one, /two'
    assert contests['b2'] is None
