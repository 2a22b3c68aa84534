"""A script may be long: its tree is as small, and an order of it as soon taken, as of a short one.

Counted in calls and behaviours, which are the same on every machine.
"""

from __future__ import annotations

import pickle

import pytest
from fakes.board import tidy_after
from fakes.calls import calls
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import Line
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench, show
from fakes.profiles import examples
from fakes.small_pages import small_pages
from fakes.virtual_run import VirtualRun
from hypothesis import given
from py_trees.blackboard import Blackboard

from bt_orchestrator.engine.tree.section import MOST_WHOLE, PAGE
from bt_orchestrator.model.codec import digest, text_of
from bt_orchestrator.model.events.tasks import TaskStarted
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

LINE = Line()
MANY = 2000


def long_script(tasks: int, *, grouped: bool = False) -> Script:
    """Return a script with so many tasks in section 2, in one list or in a track of a group."""
    ids = [f'{{id: t{n}, @{"ab"[n % 2]}2}}' for n in range(tasks)]
    group = f'- parallel:\n    - [{", ".join(ids)}]\n    - {{id: beside, @arm}}'
    listed = group if grouped else '\n'.join(f'- {entry}' for entry in ids)
    text = '\n'.join(f'    {line}' for line in listed.splitlines())
    return LINE.script(
        f'sections:\n  1: [{{id: place, @a1, qty_change: 1}}]\n  2:\n{text}\n'
        '  3: [{id: pack, @a3, qty_change: -1}]\n'
    )


def as_read(script: Script) -> Script:
    """Return a script as it comes from the process that reads orders."""
    digest(script)
    text_of(script)
    script.work_out()
    read: Script = pickle.loads(pickle.dumps(script))
    return read


@pytest.mark.parametrize('grouped', [False, True])
def test_long_list_keeps_tree_small(grouped: bool) -> None:
    # A bare simulation: what else a virtual run checks would compare all of the script each time.
    store = MemoryStore()
    simulation = Simulation(LINE.cell, LINE.types, store)
    orchestrator, clock = simulation.orchestrator, simulation.clock
    tidy_after(orchestrator)
    simulation.submit([Job('J', long_script(MANY, grouped=grouped), 1)])
    clients, most = len(Blackboard.clients), 0
    for moment in range(50, 500, 50):
        while clock.now() < moment:
            orchestrator.settle()
            clock.advance()
        most = max(most, sum(1 for _ in orchestrator.tree.root.iterate()))
        assert len(Blackboard.clients) <= clients + 5 * PAGE
    orchestrator.settle()
    last = [event.task for event in store.read(0) if isinstance(event, TaskStarted)][-1]
    assert int(last.removeprefix('t')) > 400
    assert most < 10 * PAGE + 2 * MANY / PAGE


def test_order_of_long_script_stays_cheap() -> None:
    def taken(tasks: int) -> int:
        simulation = Simulation(LINE.cell, LINE.types, MemoryStore())
        job = Job('J', as_read(long_script(tasks)), 1)
        return calls(lambda: simulation.orchestrator.ask(AddJobs((job,))))

    assert taken(MANY) - taken(MOST_WHOLE + 1) < 10 * MANY


@pytest.mark.parametrize('grouped', [False, True])
def test_long_list_runs_in_order(grouped: bool) -> None:
    tasks = MOST_WHOLE + 5
    run = VirtualRun(LINE.cell, LINE.types, viewed=True, rebuild=range(100, 200, 7))
    run.submit('J', long_script(tasks, grouped=grouped), 1)
    assert run.go().ended
    done = [task for task in run.order('task.succeeded', 'task') if task.startswith('t')]
    assert done == [f't{n}' for n in range(tasks)]


@examples(8, 200)
@given(lines())
def test_generated_lines_in_pages_match_rebuilt_trees(plan: Plan) -> None:
    show(plan)
    with small_pages(2):
        operate(ProductBench(plan, viewed=True), plan.moments)


@examples(20, 500)
@given(lines())
def test_drawn_lines_go_the_same_way_in_pages(plan: Plan) -> None:
    show(plan)
    runs = []
    for size in (0, 1):
        with small_pages(size):
            bench = ProductBench(plan)
            operate(bench, plan.moments)
            runs.append(bench.run.records)
    assert runs[0] == runs[1]
