"""What holds for every line, over lines that nobody wrote by hand (semantics, all of it).

`fakes.naive_cell` is a second opinion, written from the rules; it shares nothing with the product.
Every settle of every run is checked by `fakes.invariants` and by a replay (`fakes.virtual_run`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Moment, Order, Plan, Row, Traits
from fakes.event_format import mistake_in
from fakes.plan_operator import SETS_UP, operate
from fakes.plan_runs import (
    NaiveBench,
    ProductBench,
    comparable,
    refused,
    show,
)
from fakes.profiles import PROFILE, examples
from hypothesis import given

pytestmark = pytest.mark.timeout(24 * 3600)

DRAWS = (1.0,), (0.0, 7.0, 0.5), (8.0, 0.1, 3.3, 0.0, 6.0)
"""Durations under which a verdict is tried: even, and two sorts of uneven ones.

None is so long that a task times out: `abort_job` would free a line that is stuck.
"""


Draws = Sequence[tuple[float, ...]]


def draws_of(line: int) -> Draws:
    """Return what a line is tried with; one of all in the gate, where three are half its time."""
    return [DRAWS[line % len(DRAWS)]] if PROFILE == 'gate' else DRAWS


def verdicts(
    kind: type[NaiveBench | ProductBench], plan: Plan, script: str, draws: Draws
) -> list[bool]:
    """Tell for each draw whether a job of one script alone gets stuck, where nothing fails."""
    orders = (Order('J', script, 3 * plan.cell['conveyor']['sections']),)
    alone = replace(plan, orders=orders, later=(), moments=()).without_faults()
    return [not operate(kind(replace(alone, seconds=seconds)), ()) for seconds in draws]


OF_JOBS = (
    *('job.held', 'job.released', 'job.moved', 'job.updated', 'job.removed'),
    *('job.paused', 'job.stopping', 'queue.stop_requested', 'queue.stop_reached'),
    'queue.arranged',
)
"""What operators ask of jobs and of the queue."""


DRAWN = 13
"""Seed of the gate: with it each kind of line is drawn often enough for the shares below."""


@pytest.mark.long
def test_9_1_every_line_goes_as_the_second_opinion_says() -> None:
    """Event for event, whatever fails, whoever answers what, and whenever the tree is rebuilt.

    A script that is refused gets stuck, and an accepted one does not, however long tasks take.
    """
    seen: Counter[str] = Counter()

    @examples(200, 2000, drawn=DRAWN)
    @given(lines())
    def holds(plan: Plan) -> None:
        show(plan)
        product = ProductBench(plan)
        ended = operate(product, plan.moments)
        naive = NaiveBench(plan, product.refused)
        assert operate(naive, plan.moments) == ended
        records = product.run.records
        assert comparable(records) == naive.cell.records
        assert [mistake for mistake in map(mistake_in, records) if mistake] == []
        draws = draws_of(seen['all'])
        stuck = refused(plan)
        for name in product.scripts:
            assert verdicts(NaiveBench, plan, name, draws) == [name in stuck] * len(draws), name
        for name in stuck:
            assert verdicts(ProductBench, plan, name, draws) == [True] * len(draws), name
        if stuck.isdisjoint(product.accepted.values()):
            assert ended, product.run.waits()
        seen['all'] += 1
        seen['refused'] += bool(stuck)
        seen['two jobs'] += len(product.accepted) > 1
        seen['stopped'] += 'Stopped' in product.run.states
        seen['aborted'] += 'Aborted' in product.run.states
        seen['faults'] += plan.has_faults
        seen['result_refused'] += 'result_refused' in product.run.reasons()
        seen['rounds'] += bool(product.run.all('round.begun'))
        seen['identified'] += bool(product.run.all('item.identified'))
        seen['duplicates'] += 'duplicate_serial' in product.run.reasons()
        seen['let pass'] += bool(product.run.all('item.nonconforming'))
        seen['waited'] += bool(product.run.all('job.may_start'))
        seen['out of service'] += bool(product.run.all('component.out_of_service'))
        seen['passed'] += any('jobs' in o for o in product.run.all('component.out_of_service'))
        seen['generated'] += any('awaits_release' in o for o in product.run.all('job.queued'))
        seen['released'] += bool(product.run.all('script.released'))
        seen['placed'] += any('position' in record for record in product.run.all('job.queued'))

        seen.update(event for event in OF_JOBS if product.run.all(event))
        seen['requeued'] += any('rest_of' in record for record in product.run.all('job.queued'))
        seen['taken back'] += bool(product.run.all('queue.stop_cancelled'))

    holds()
    if PROFILE == 'shard':
        return  # a round has too few lines for shares of them
    assert seen['all'] >= 200, seen
    assert [event for event in OF_JOBS if not seen[event]] == [], seen
    assert seen['requeued'] >= 0.01 * seen['all'], seen
    assert seen['refused'] >= 0.1 * seen['all'], seen
    assert seen['two jobs'] >= 0.3 * seen['all'], seen
    assert seen['stopped'] >= 0.02 * seen['all'], seen
    assert seen['aborted'] >= 0.02 * seen['all'], seen
    assert seen['result_refused'] >= 0.1 * seen['all'], seen
    assert seen['rounds'] >= 0.02 * seen['all'], seen
    assert seen['identified'] >= 0.05 * seen['all'], seen
    assert seen['duplicates'] >= 0.01 * seen['all'], seen
    assert seen['let pass'] >= 0.02 * seen['all'], seen
    assert seen['faults'] >= 0.3 * seen['all'], seen
    assert seen['waited'] >= 0.05 * seen['all'], seen
    assert seen['out of service'] >= 0.02 * seen['all'], seen
    assert seen['passed'] >= 0.02 * seen['all'], seen
    assert seen['generated'] >= 0.02 * seen['all'], seen
    assert seen['released'] >= 0.02 * seen['all'], seen
    assert seen['placed'] >= 0.02 * seen['all'], seen


@examples(40, 400)
@given(lines(Traits(short=True)))
def test_5_1_short_orders_go_as_the_second_opinion_says(plan: Plan) -> None:
    """The last section prepares for each order what the order says, once for orders alike."""
    show(plan)
    product = ProductBench(plan)
    ended = operate(product, plan.moments)
    naive = NaiveBench(plan, product.refused)
    assert operate(naive, plan.moments) == ended
    assert comparable(product.run.records) == naive.cell.records


def test_7_7_runs_of_rejects_match_second_opinion() -> None:
    """Limits of cells and of scripts, over jobs and stops, with answers at any moment."""
    seen: Counter[str] = Counter()

    @examples(60, 600)
    @given(lines(Traits(rejects=True)))
    def holds(plan: Plan) -> None:
        show(plan)
        product = ProductBench(plan)
        ended = operate(product, plan.moments)
        naive = NaiveBench(plan, product.refused)
        assert operate(naive, plan.moments) == ended
        assert comparable(product.run.records) == naive.cell.records
        raised = product.run.all('hold.raised', reason='too_many_rejects')
        seen['all'] += 1
        seen['held'] += bool(raised)
        seen['of several jobs'] += any(
            len({i.split('/')[0] for i in o['items']}) > 1 for o in raised
        )
        seen['twice'] += len(raised) > 1

    holds()
    if PROFILE != 'shard':
        assert seen['held'] >= 0.2 * seen['all'], seen
        assert seen['of several jobs'], seen
        assert seen['twice'], seen


def test_6_12_first_pieces_go_as_the_second_opinion_says() -> None:
    """They are approved and refused at any moment, or their jobs end."""
    seen: Counter[str] = Counter()

    @examples(60, 600, drawn=DRAWN)
    @given(lines(Traits(pieces=True)))
    def holds(plan: Plan) -> None:
        show(plan)
        product = ProductBench(plan)
        ended = operate(product, plan.moments)
        naive = NaiveBench(plan, product.refused)
        assert operate(naive, plan.moments) == ended
        assert comparable(product.run.records) == naive.cell.records
        resumed = [record for record in product.run.all('job.resumed') if 'item' in record]
        seen['all'] += 1
        seen['approved'] += any('another' not in record for record in resumed)
        seen['another'] += any('another' in record for record in resumed)
        seen['stopped'] += any('item' in record for record in product.run.all('job.stopping'))

    holds()
    if PROFILE != 'shard':
        assert seen['approved'] >= 0.05 * seen['all'], seen
        assert seen['another'] >= 0.05 * seen['all'], seen
        assert seen['stopped'], seen


@examples(60, 600)
@given(lines(Traits(setups=True)))
def test_5_3_setups_go_as_the_second_opinion_says(plan: Plan) -> None:
    """Components are set up for jobs, lose their setups, and get them back by answers."""
    show(plan)
    product = ProductBench(plan)
    ended = operate(product, plan.moments)
    naive = NaiveBench(plan, product.refused)
    assert operate(naive, plan.moments) == ended
    assert comparable(product.run.records) == naive.cell.records


def told_line(faults: list[str], moments: tuple[Moment, ...]) -> Plan:
    """Return a line of two jobs, whose second section tells what it is set up for."""
    kind = 'bt_orchestrator_interfaces/action'
    topic = {'topic': '/a2/state', 'type': 'diagnostic_msgs/msg/KeyValue', 'field': 'key'}
    change = {'task': 'TASK_C', 'argument': 'special_argument_1', 'reads': 'value'}
    stations: Row = {
        f'a{n}': {'section': n, 'action': f'/a{n}/do', 'type': f'{kind}/Component'} for n in (1, 2)
    }
    stations['a2'] |= {'state': {**topic, 'ready': ['READY']}, 'faults': faults}
    stations['a2'] |= {'setups': {'tool': ['x', 'y']}, 'changes': {'tool': change}}
    belt = {'sections': 2, 'action': '/belt/do', 'type': f'{kind}/Conveyor'}
    belt |= {'task': 'MOVE_ONE_INDEX', 'duration': 2.0137}
    place = {'id': 'place', 'task': 'TASK_A', 'action': '/a1/do', 'qty_change': 1}
    pack = {'id': 'pack', 'task': 'TASK_A', 'action': '/a2/do', 'qty_change': -1}
    packs: dict[str, Row] = {tool: {**pack, 'setup': {'tool': tool}} for tool in 'xy'}
    scripts = [
        {'script': f'script_{tool}', 'sections': {1: [place], 2: [task]}}
        for tool, task in packs.items()
    ]
    orders = (Order('J0', 'script_x', 2), Order('J1', 'script_y', 2))
    cell = {'cell': 'told_cell', 'conveyor': belt, 'components': stations}
    return Plan(cell, tuple(scripts), orders, (), moments, (), frozenset())


def test_5_3_setups_from_topics_match_second_opinion() -> None:
    """Whatever is set up by hand, and whenever; some of it while the line changes it."""
    seen: Counter[str] = Counter()
    choices = [Moment(0.13, SETS_UP), Moment(3.71, 0), Moment(3.71, SETS_UP), Moment(17.93, 1)]
    sequences = product(
        (*choices, Moment(61.57, SETS_UP)), repeat=3 if PROFILE == 'nightly' else 2
    )
    some: list[list[str]] = [[], ['#1=abort'], ['#1=late:9.1', '#3=false']]
    for faults, moments in product(some, sequences):
        plan = told_line(faults, moments)
        run = ProductBench(plan)
        ended, naive = operate(run, moments), NaiveBench(plan)
        assert operate(naive, moments) == ended, moments
        assert comparable(run.run.records) == naive.cell.records, moments
        seen['held'] += bool(run.run.all('hold.raised', reason='setup_missing'))
        seen['told in time'] += not run.run.all('hold.raised')
        changes = [record['job'] for record in run.run.all('task.started', name='TASK_C')]
        seen['changed again'] += len(changes) > len({*changes})
    assert min(seen['held'], seen['changed again']) > 0, seen
