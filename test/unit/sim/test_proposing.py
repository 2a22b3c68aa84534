"""An order for the queue: what is proposed, and that nothing better exists."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import permutations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import Arrange, ControlJob, MoveJob
from fakes.line import THREE, Line
from fakes.operator import engineer

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.ports import Consequence, Moment, Proposal
from bt_orchestrator.sim import proposing
from bt_orchestrator.sim.proposing import FEW, GUESSES, KEPT, QueueOrders, Waiting
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.sim.what_if import EngineWhatIf
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
BY = engineer('Ann')
LINE = Line(3, seconds={'a2': 5.0})
SCRIPT = LINE.script(THREE)
ITEM_S = 7.0
"""An item each: the slowest section, and the move of the belt."""


def order(name: str, quantity: int, due: float | None = None, priority: int = 0) -> Job:
    return Job(name, SCRIPT, quantity, terms=Terms(priority, due=due))


@contextmanager
def line_with(*jobs: Job, until_s: float = 1.0) -> Iterator[Simulation]:
    """Give a line on which a job runs, with others behind it."""
    simulation = Simulation(LINE.cell, TYPES, MemoryStore())
    simulation.submit([order('first', 2)])
    for job in jobs:
        assert simulation.orchestrator.ask(AddJobs((job,), BY)).accepted
    go(simulation, until_s)
    yield simulation
    simulation.close()


def go(simulation: Simulation, until_s: float = math.inf) -> None:
    simulation.orchestrator.settle()
    while simulation.state.jobs:
        due = simulation.clock.next_deadline()
        if due is None or due > until_s:
            return
        simulation.clock.advance()
        simulation.orchestrator.settle()


def what_if(simulation: Simulation) -> EngineWhatIf:
    plain = json.loads(json.dumps(state_to_plain(simulation.state)))
    return EngineWhatIf(Moment(simulation.state.cell, plain, simulation.clock.now()), TYPES)


def proposed(simulation: Simulation) -> Proposal:
    return what_if(simulation).propose()


def late_s(consequence: Consequence, simulation: Simulation) -> float:
    """Return how late jobs end together, of what would be."""
    now_s = simulation.clock.now()
    dues = {name: entry.job.terms.due for name, entry in simulation.state.jobs.items()}
    ends = {entry.job: entry.ends_s for entry in consequence.after}
    return sum(
        max(0.0, now_s + (ends[name] or 0.0) - due)
        for name, due in dues.items()
        if due is not None
    )


def after_moves(simulation: Simulation, names: Sequence[str]) -> Consequence:
    """Return what would be if the queue were in an order, by moves of its jobs."""
    moves = [MoveJob(name, place, BY) for place, name in enumerate(names, start=1)]
    return what_if(simulation).ask(moves)


MIXES = (
    [('A', 6, 60.0), ('B', 1, 40.0), ('C', 2, 50.0), ('D', 3, None)],
    [('A', 1, 200.0), ('B', 4, 30.0), ('C', 2, 60.0), ('D', 1, 45.0)],
    [('A', 5, 90.0), ('B', 3, 91.0), ('C', 1, 92.0), ('D', 2, 70.0)],
)


@pytest.mark.parametrize('mix', MIXES)
def test_6_7_proposal_has_least_lateness_of_few_orders(
    mix: list[tuple[str, int, float | None]],
) -> None:
    with line_with(*(order(*row) for row in mix)) as simulation:
        proposal = proposed(simulation)
        names = [name for name, *_ in mix]
        every = {
            row: late_s(after_moves(simulation, row), simulation) for row in permutations(names)
        }
        least_s = min(every.values())
        assert proposal.new_late_s == pytest.approx(least_s, abs=0.001 * len(mix))
        assert every[tuple(proposal.order)] == pytest.approx(least_s, abs=0.001 * len(mix))
        assert proposal.late_s == pytest.approx(every[tuple(names)], abs=0.001 * len(mix))
        assert proposal.late_s > proposal.new_late_s
        assert (proposal.is_best, proposal.orders) == (True, 24)
        assert proposal.is_new
        best = [row for row, late in every.items() if late < least_s + 0.0005]
        moved = {row: sum(abs(row.index(n) - names.index(n)) for n in names) for row in best}
        assert moved[tuple(proposal.order)] == min(moved.values()), 'the least is moved'


def test_what_is_proposed_is_what_then_happens() -> None:
    with line_with(*(order(*row) for row in MIXES[0])) as simulation:
        offer = proposed(simulation)
        now_s = simulation.clock.now()
        asked = Arrange(offer.order, offer.queue_digest, BY)
        assert simulation.orchestrator.ask(asked).accepted
        go(simulation)
        ends = {name: row.ended_at for name, row in simulation.state.ended.items()}
    assert {row.job: now_s + (row.new_ends_s or 0.0) for row in offer.jobs} == pytest.approx(ends)
    with line_with(*(order(*row) for row in MIXES[0])) as simulation:
        go(simulation)
        ends = {name: row.ended_at for name, row in simulation.state.ended.items()}
    assert {row.job: now_s + (row.ends_s or 0.0) for row in offer.jobs} == pytest.approx(ends)


def test_6_7_priority_comes_before_lateness() -> None:
    late = [order('A', 9, 300.0, priority=1), order('B', 1, 20.0), order('C', 1, 10.0)]
    with line_with(*late) as simulation:
        proposal = proposed(simulation)
    assert proposal.order[0] == 'A'
    assert proposal.orders == 2
    assert proposal.new_late_s > 60.0


def test_6_7_order_without_late_jobs_stays_unchanged() -> None:
    early = [order('A', 1, 900.0), order('B', 1), order('C', 1, 800.0), order('D', 1, 850.0)]
    with line_with(*early) as simulation:
        proposal = proposed(simulation)
    assert (proposal.is_new, proposal.is_best, proposal.looked_at) == (False, True, 1)
    assert (proposal.order, proposal.new_late_s) == (['A', 'B', 'C', 'D'], 0.0)


Change = Callable[[Simulation], object]


@pytest.mark.parametrize(
    ('change', 'job', 'why'),
    [
        (lambda entry: entry.orchestrator.ask(MoveJob('A', 1, BY)), 'A', 'its place was chosen'),
        (
            lambda entry: entry.orchestrator.ask(ControlJob('hold', 'A', BY)),
            'A',
            'A is held in the queue',
        ),
    ],
)
def test_6_7_what_a_person_decided_stays(change: Change, job: str, why: str) -> None:
    jobs = [order('A', 9, 500.0), order('B', 3, 35.0), order('C', 1, 25.0)]
    with line_with(*jobs) as simulation:
        assert proposed(simulation).order == ['C', 'B', 'A']
        change(simulation)
        proposal = proposed(simulation)
    assert proposal.order == ['A', 'C', 'B']
    assert {entry.job: entry.stays for entry in proposal.jobs if entry.stays} == {job: why}


def test_unknown_end_is_explained_and_hides_no_job() -> None:
    jobs = [order('A', 9), order('B', 9, 500.0), order('C', 1, 25.0)]
    with line_with(*jobs) as simulation:
        simulation.orchestrator.ask(ControlJob('hold', 'A', BY))
        proposal = proposed(simulation)
    assert proposal.order == ['A', 'C', 'B']
    assert list(proposal.unknown) == ['A']
    assert {entry.job for entry in proposal.jobs if entry.new_ends_s is None} == {'A'}


def test_6_7_next_job_passes_job_awaiting_its_start() -> None:
    """D is due first, but does not start before 60 s: nothing is gained by moving it."""
    waits = Job('D', SCRIPT, 1, terms=Terms(start=60.0, due=80.0))
    with line_with(order('B', 1, 40.0), order('C', 6, 78.0), waits) as simulation:
        proposal = proposed(simulation)
        every = {
            plan: late_s(after_moves(simulation, plan), simulation) for plan in permutations('BCD')
        }
    assert proposal.new_late_s == pytest.approx(min(every.values()), abs=0.003)


def test_long_queue_gets_best_of_compared_orders(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Jobs alike: what is due first comes first, as no order is better then."""
    monkeypatch.setattr(proposing, 'MOST_STEPS', 2000)
    dues = [130.0, 40.0, 100.0, 60.0, 90.0, 50.0, 120.0, 80.0]
    jobs = [order(f'J{number}', 2, due) for number, due in enumerate(dues)]
    with line_with(*jobs) as simulation:
        proposal, again = proposed(simulation), proposed(simulation)
        by_due = sorted((due, job.id) for due, job in zip(dues, jobs, strict=True))
        least = late_s(after_moves(simulation, [name for _, name in by_due]), simulation)
    assert proposal == again
    assert proposal.new_late_s == pytest.approx(least, abs=0.01)
    assert (proposal.orders, proposal.is_best) == (math.factorial(8), False)
    assert 1 < proposal.looked_at <= KEPT + 1


def test_the_work_for_a_proposal_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proposing, 'MOST_STEPS', 1)
    with line_with(*(order(*spec) for spec in MIXES[0])) as simulation:
        proposal = proposed(simulation)
    assert (proposal.looked_at, proposal.is_best) == (2, False)
    assert proposal.new_late_s < proposal.late_s


def test_an_empty_queue_has_one_order() -> None:
    with line_with() as simulation:
        proposal = proposed(simulation)
    assert [(entry.job, entry.place) for entry in proposal.jobs] == [('first', 0)]
    assert (proposal.orders, proposal.is_best, proposal.is_new) == (1, True, False)


# --- what is looked at first ------------------------------------------------------------------


def test_few_orders_are_listed_without_moving_fixed_jobs() -> None:
    jobs = [Waiting(0, True, 5.0), Waiting(0, False, 1.0), Waiting(2, True, 9.0)]
    orders = QueueOrders([*jobs, Waiting(0, True, 2.0)])
    assert orders.count == 2
    assert sorted(orders.promising()) == [(2, 1, 0, 3), (2, 1, 3, 0)]
    assert orders.change((2, 1, 0, 3)) == 4


def test_many_orders_are_limited_and_well_guessed() -> None:
    works = [3.0, 9.0, 1.0, 7.0, 2.0, 8.0, 4.0, 6.0, 5.0]
    jobs = [Waiting(0, True, 12.0 + at % 4 * 6, work_s=work) for at, work in enumerate(works)]
    orders = QueueOrders(jobs)
    assert orders.count > FEW
    guesses = orders.promising()
    assert len(set(guesses)) == len(guesses) == KEPT
    assert all(sorted(sequence) == list(range(9)) for sequence in guesses)

    def late(sequence: Sequence[int]) -> float:
        now_s = total_s = 0.0
        for at in sequence:
            now_s += works[at]
            total_s += max(0.0, now_s - jobs[at].due_s)
        return total_s

    least = [late(sequence) for sequence in guesses]
    assert least == sorted(least)
    assert least[0] == min(map(late, permutations(range(9))))


def test_a_very_long_queue_is_guessed_within_bounds() -> None:
    jobs = [Waiting(at % 3, True, at * 37 % 101, work_s=1.0 + at % 5) for at in range(100)]
    orders = QueueOrders(jobs)
    rows = orders.promising()
    assert len(rows) == KEPT
    assert len(orders._guesses) <= GUESSES + 3, 'and those that it begins with'
    assert all([jobs[at].priority for at in row] == [2] * 33 + [1] * 33 + [0] * 34 for row in rows)


# --- three products with setups (5.3) ---------------------------------------------------------

TWO_SETUPS = (
    'setups: {gripper: [small, large], program: [plain, printed]}, durations: {TASK_B: 3.0, '
    'TASK_C: 12.0}, changes: {gripper: {task: TASK_C, argument: special_argument_1}, '
    'program: {task: TASK_B, argument: special_argument_1}}'
)
PRODUCTS = Line(3, keys={'a2': TWO_SETUPS})
SET_UP_S = 16.0
"""By then the first job is set up."""
SETUP_OF = {
    'box': '{gripper: small, program: plain}',
    'crate': '{gripper: large, program: plain}',
    'gift': '{gripper: large, program: printed}',
}
SCRIPTS = {
    name: PRODUCTS.script(THREE.replace('id: work, @a2', f'id: work, @a2, setup: {setup}'), name)
    for name, setup in SETUP_OF.items()
}


def product(name: str, script: str, due: float | None = None, priority: int = 0) -> Job:
    quantity = 6 if name == 'first' else 2
    return Job(name, SCRIPTS[script], quantity, terms=Terms(priority, due=due))


@contextmanager
def line_of_products(*jobs: Job, until_s: float = SET_UP_S) -> Iterator[Simulation]:
    """Give a line on which a box is made, with others behind it."""
    simulation = Simulation(PRODUCTS.cell, TYPES, MemoryStore())
    simulation.submit([product('first', 'box')])
    for job in jobs:
        assert simulation.orchestrator.ask(AddJobs((job,), BY)).accepted
    go(simulation, until_s)
    yield simulation
    simulation.close()


def outcome(simulation: Simulation) -> tuple[float, float]:
    """Run a line to its end; return the seconds of changes since the first job, and the end."""
    begun: dict[str, float] = {}
    go(simulation)
    changes_s = 0.0
    for event in simulation.orchestrator._store.read():
        if isinstance(event, e.TaskStarted) and event.name in ('TASK_B', 'TASK_C'):
            begun[f'{event.job} {event.task}'] = event.time
        elif isinstance(event, e.TaskSucceeded) and event.job != 'first':
            changes_s += event.time - begun.pop(f'{event.job} {event.task}', event.time)
    return changes_s, simulation.clock.now()


MIXED = (('A', 'gift'), ('B', 'box'), ('C', 'crate'), ('D', 'box'), ('E', 'gift'))


def test_6_7_proposal_predicts_changeover_savings_of_simulation() -> None:
    jobs = [product(*entry) for entry in MIXED]
    with line_of_products(*jobs) as simulation:
        proposal = proposed(simulation)
        assert proposal.is_best
        assert list(proposal.order) == ['B', 'D', 'C', 'A', 'E']
        now_s, now_ends_s = outcome(simulation)
    with line_of_products(*jobs) as simulation:
        answer = simulation.orchestrator.ask(Arrange(proposal.order, proposal.queue_digest, BY))
        assert answer.accepted, answer.message
        then_s, then_ends_s = outcome(simulation)
    assert (now_s, then_s) == pytest.approx((69.0, 15.0))
    assert (proposal.changeover_s, proposal.new_changeover_s) == pytest.approx((now_s, then_s))
    ends_s = max(entry.ends_s or 0.0 for entry in proposal.jobs)
    new_ends_s = max(entry.new_ends_s or 0.0 for entry in proposal.jobs)
    assert ends_s - new_ends_s == pytest.approx(now_ends_s - then_ends_s)
    assert now_ends_s > then_ends_s


def test_6_7_lateness_goes_before_changes() -> None:
    jobs = [product('A', 'gift', due=20.0), product('B', 'box'), product('C', 'gift')]
    with line_of_products(*jobs) as simulation:
        proposal = proposed(simulation)
    assert proposal.new_changeover_s < proposal.changeover_s
    assert list(proposal.order) == ['A', 'C', 'B']


def test_6_7_priority_goes_before_changes() -> None:
    jobs = [product('A', 'gift', priority=1), product('B', 'box'), product('C', 'gift')]
    with line_of_products(*jobs) as simulation:
        assert list(proposed(simulation).order) == ['A', 'C', 'B']


def test_a_long_queue_is_guessed_with_its_changes() -> None:
    jobs = [product(f'J{n}', ('gift', 'box', 'crate')[n % 3]) for n in range(7)]
    with line_of_products(*jobs) as simulation:
        proposal = proposed(simulation)
    assert not proposal.is_best
    assert proposal.new_changeover_s == pytest.approx(15.0)
    assert proposal.changeover_s > 60.0


def test_cell_without_auto_start_accepts_queue_proposal() -> None:
    simulation = Simulation(LINE.cell, TYPES, MemoryStore(), auto_start=False)
    for job in (order('A', 3), order('B', 1, 20.0)):
        assert simulation.orchestrator.ask(AddJobs((job,), BY)).accepted
    simulation.orchestrator.settle()
    assert not simulation.state.jobs.line
    proposal = proposed(simulation)
    assert [(entry.job, entry.new_place) for entry in proposal.jobs] == [('B', 1), ('A', 2)]
    answer = simulation.orchestrator.ask(Arrange(proposal.order, proposal.queue_digest, BY))
    assert answer.accepted, answer.message
    simulation.close()
