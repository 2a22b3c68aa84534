"""Semantics 5.1: what need not be done again for the next job."""

from __future__ import annotations

import pytest
from fakes.commands import Abort, Reset, RunNext, Start, Stop
from fakes.line import Line, with_initialization
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.packml import PackmlState

HOME = with_initialization('[{id: home, task: HOME, action: /belt/do, once: true}]')


def jobs_of(run: VirtualRun, *tasks: str) -> list[str]:
    """Return for which jobs tasks were started, in order."""
    return [record['job'] for record in run.all('task.started') if record['task'] in tasks]


def test_5_1_once_is_skipped_after_source_finishes_earlier_jobs() -> None:
    line = Line()
    run = line.begin(HOME, 3)
    run.go(until=1.0)
    run.submit('K', line.script(HOME), 1)
    run.go()
    assert run.starts('home') == [0.0]
    assert run.times('task.skipped', task='home', job='K') == [9.0]  # not after the line drained
    assert run.starts('place', job='K') == [11.0]  # at once behind the last item of J


def test_5_1_task_without_once_waits_for_drained_line() -> None:
    text = HOME.replace(', once: true', '')
    line = Line()
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 1)
    run.go()
    assert run.starts('home', job='K') == run.times('job.completed', job='J') == [9.0]


def test_5_1_once_compares_action_task_and_arguments() -> None:
    text = with_initialization(
        """
      - {id: aim, @a1.PREPARE, once: true, args: {special_argument_2: "${params.x}"}}
params: {x: {type: float}}"""
    )
    line = Line()
    run = line.begin(text, 1, x=1.0)
    run.submit('K', line.script(text), 1, x=1.0)
    run.submit('L', line.script(text), 1, x=2.0)
    run.go()
    assert jobs_of(run, 'aim') == ['J', 'L']


def test_5_1_once_counts_only_a_success() -> None:
    text = HOME.replace('once: true', 'once: true, on_failure: continue')
    line = Line(faults={'conveyor': 'HOME#1=abort'})
    run = line.begin(text, 1)
    run.submit('K', line.script(text), 1)
    run.go()
    assert jobs_of(run, 'home') == ['J', 'K']


def test_5_1_once_is_forgotten_in_stopped() -> None:
    line = Line()
    run = line.run(HOME)
    run.command(Stop)
    assert run.state.packml.value == 'Stopped'
    run.submit('K', line.script(HOME), 1)
    run.command(Reset)
    run.command(Start)
    run.go()
    assert jobs_of(run, 'home') == ['J', 'K']


def test_5_1_queued_job_runs_once_task_after_stop() -> None:
    """Somebody may have moved the belt by hand while the cell stood: K homes it again."""
    line = Line()
    run = line.begin(HOME)
    run.submit('K', line.script(HOME), 1)
    run.go(until=2.0)
    for command in (Stop, Reset, Start):
        assert run.command(command).accepted
        run.go(until=run.now + 5.0)
    run.go()
    assert run.ended
    assert jobs_of(run, 'home') == ['J', 'K']


def test_5_1_stopped_cell_forgets_skips_of_unbegun_job() -> None:
    text = HOME.replace('once: true}', 'once: true}, {id: load, @b1.PREPARE}')
    line = Line(seconds={'b1': 5.0})
    run = line.begin(text)
    run.submit('K', line.script(text), 1)
    run.go(until=9.0)
    assert run.all('task.skipped', job='K', task='home')  # while its other task runs
    for command in (Stop, Reset, Start):
        assert run.command(command).accepted
        run.go(until=run.now + 5.0)
    run.go()
    assert run.ended
    assert jobs_of(run, 'home') == ['J', 'K']
    assert jobs_of(run, 'load') == ['J', 'K']


def test_5_1_aborted_cell_forgets_skips_of_unbegun_job() -> None:
    text = HOME.replace('once: true}', 'once: true}, {id: load, @b1.PREPARE}')
    line = Line(seconds={'b1': 5.0})
    run = line.begin(text)
    run.submit('K', line.script(text), 1)
    run.go(until=9.0)
    run.command(Abort)
    run.go(until=10.0)
    assert run.state.packml is PackmlState.ABORTED
    assert run.state.phase(TaskKey('K', None, None, 'home')) is None


RECIPE = with_initialization(
    '[{id: load, @a2.PREPARE, once: true, args: {special_argument_2: "${params.x}"}}]',
    'params: {x: {type: float}}\n',
)


def recipes(values: str, line: Line | None = None, text: str = RECIPE) -> VirtualRun:
    """Run jobs J, K, L, ... of one item, each with its recipe, all queued at the beginning."""
    line = line or Line()
    run = line.begin(text, x=float(values[0]))
    for name, value in zip('KLMN', values[1:], strict=False):
        run.submit(name, line.script(text), 1, x=float(value))
    run.go()
    assert run.ended
    return run


@pytest.mark.parametrize(
    ('values', 'loaded'),
    [('111', 'J'), ('121', 'JKL'), ('112', 'JL'), ('1221', 'JKM'), ('12121', 'JKLMN')],
)
def test_5_1_recipe_is_loaded_at_each_change(values: str, loaded: str) -> None:
    assert jobs_of(recipes(values), 'load') == list(loaded)


def test_5_1_job_put_in_front_loads_its_recipe() -> None:
    line = Line()
    run = line.begin(RECIPE, 2, x=1.0)
    run.submit('K', line.script(RECIPE), 1, x=1.0)
    run.go(until=3.0)
    run.submit('L', line.script(RECIPE), 1, x=2.0)
    assert run.ask(RunNext('L', BY)).accepted
    run.go()
    assert jobs_of(run, 'load') == ['J', 'L', 'K']


def test_5_1_failed_attempt_with_other_arguments_unloads_recipe() -> None:
    text = RECIPE.replace('once: true', 'once: true, on_failure: continue')
    run = recipes('121', Line(faults={'a2': 'PREPARE#2=abort'}), text)
    assert jobs_of(run, 'load') == ['J', 'K', 'L']


def test_5_1_an_attempt_in_doubt_leaves_nothing_loaded() -> None:
    line = Line(faults={'b2': 'PREPARE#2=ignore_cancel'})
    text = RECIPE.replace('once: true', 'once: true, timeout: 2.0').replace('@a2.', '@b2.')
    run = line.begin(text, x=1.0)
    run.submit('K', line.script(text), 1, x=2.0)
    run.submit('L', line.script(text), 1, x=1.0)
    run.go()
    (hold,) = run.state.holds.values()
    assert (hold.job, hold.reason) == ('K', 'in_doubt')
    run.answer('skip')
    run.go()
    assert jobs_of(run, 'load') == ['J', 'K', 'L']


def test_5_1_failed_attempt_with_same_arguments_unloads_recipe() -> None:
    line = Line(faults={'a2': 'PREPARE#2=abort'})
    always = RECIPE.replace('once: true', 'on_failure: continue')
    run = line.begin(RECIPE, x=1.0)
    run.submit('K', line.script(always, 'always'), 1, x=1.0)
    run.submit('L', line.script(RECIPE), 1, x=1.0)
    run.go()
    assert jobs_of(run, 'load') == ['J', 'K', 'L']


@pytest.mark.parametrize(('x', 'loaded'), [(1.0, 'J'), (2.0, 'JK')])
def test_5_1_a_task_of_a_section_counts_as_well(x: float, loaded: str) -> None:
    """The list of section 2 runs the same task, with the same arguments or with others."""
    again = f'@a2.PREPARE, args: {{special_argument_2: {x}}}'
    text = RECIPE.replace('{id: work, @a2}', f'{{id: work, {again}}}')
    assert jobs_of(recipes('11', text=text), 'load') == list(loaded)


def test_5_1_skip_waits_for_tasks_of_earlier_jobs() -> None:
    """The list of section 2 loads 2 at its end; K's `load` is not skipped before that."""
    other = '@a2.PREPARE, args: {special_argument_2: 2.0}'
    text = RECIPE.replace('{id: work, @a2}', f'{{id: slow, @b2}}, {{id: work, {other}}}')
    run = recipes('11', Line(seconds={'b2': 9.0}), text)
    assert jobs_of(run, 'load') == ['J', 'K']


def test_5_1_pending_task_of_earlier_job_comes_first() -> None:
    """K's `load` waits for section 2, which still works for J; L's `load` is not skipped."""
    run = recipes('121', Line(seconds={'a2': 5.0}))
    assert [record['args'] for record in run.all('task.started', task='load')] == [
        {'special_argument_2': value} for value in (1.0, 2.0, 1.0)
    ]
    assert jobs_of(run, 'load') == ['J', 'K', 'L']


def test_5_1_skip_considers_dependent_task_of_same_job() -> None:
    """K's `first` is skipped when it could start, not when the source has finished J."""
    recipe = RECIPE.replace('"${params.x}"', '1.0')
    two = with_initialization(
        """
      - {id: first, @a2.PREPARE, once: true, args: {special_argument_2: 1.0}}
      - {id: second, @a2.PREPARE, once: true, args: {special_argument_2: 2.0}}
initialization_dependencies: [{upstream: first, downstream: second}]"""
    )
    line = Line(seconds={'a2': 5.0})
    run = line.begin(recipe, x=1.0)
    run.submit('K', line.script(two, 'two'), 1)
    run.go()
    assert run.times('task.skipped', task='first') == run.times(
        'cycle.completed', job='J', section=2
    )


def test_5_1_two_recipes_of_one_job_are_both_loaded() -> None:
    text = with_initialization(
        """
      - {id: first, @a2.PREPARE, once: true, args: {special_argument_2: 1.0}}
      - {id: second, @a2.PREPARE, once: true, args: {special_argument_2: 2.0}}
initialization_dependencies: [{upstream: first, downstream: second}]"""
    )
    line = Line()
    run = line.begin(text)
    run.submit('K', line.script(text), 1)
    run.go()
    assert jobs_of(run, 'first', 'second') == ['J', 'J', 'K', 'K']


def test_5_1_skip_begins_job_like_a_start() -> None:
    line = Line()
    run = line.begin(HOME, 2)
    run.submit('K', line.script(HOME), 1)
    run.go()
    (skipped,) = run.times('task.skipped', job='K')
    assert run.times('job.started', job='K') == [skipped]
    assert skipped == run.times('cycle.completed', job='J', section=1)[-1]
