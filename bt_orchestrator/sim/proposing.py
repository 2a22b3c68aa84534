"""An order for the queue: by priority, then by how late jobs end in runs of the engine (6.7)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from typing import NamedTuple

from bt_orchestrator.engine.runtime.stands import obstacles
from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.stands import StandCause
from bt_orchestrator.model.state import JobState
from bt_orchestrator.model.state.proposed import queue_digest
from bt_orchestrator.ports import Proposal, ProposedJob
from bt_orchestrator.sim.queue_orders import FEW, Order, QueueOrders, Waiting, too_late_ms
from bt_orchestrator.sim.run_on import RunOn

MOST_STEPS = 150_000
"""Steps of all runs together, after which no further order is looked at: 20 s on a slow machine.

Not a time: equal queues get equal proposals."""

_BY = By('', 'propose', 'a proposal', Role.ENGINEER, Known.LOCAL_USER)


class _Run(NamedTuple):
    """The outcome of an order; the less, the better."""

    unknown_ends: int
    late_ms: int
    """Of all jobs together."""
    change: int
    order: Order
    ends_s: Mapping[str, float]
    """On the clock of the state."""
    unknown: Mapping[str, str]
    """Why a job does not end."""
    steps: int

    @property
    def rank(self) -> tuple[int, int, int, Order]:
        """The key by which runs are compared."""
        return self[:4]


class Proposing:
    """Proposes an order for the queue of one moment."""

    def __init__(self, begin: Callable[[], RunOn], now_s: float) -> None:
        """Prepare.

        :param begin: returns a run from that moment
        :param now_s: the moment, on the clock of the state
        """
        self._begin, self._now_s = begin, now_s
        with closing(self._begun()) as run:
            self._line = list(run.state.jobs.line.values())
            self._queue = run.state.jobs.queue(most=QUEUE_SHOWN)
            self._digest = queue_digest(run.state.jobs)

    def propose(self) -> Proposal:
        """Return the best of the orders that are looked at."""
        present = self._run(tuple(range(len(self._queue))), 0)
        orders = QueueOrders(list(self._waiting(present)), self._line_ends_s(present))
        runs, is_whole = {present.order: present}, orders.count <= FEW
        first, *others = orders.promising()
        best = present if first == present.order else self._run(first, orders.change(first))
        runs[first] = best
        for order in others:
            change = orders.change(order)
            if (0, 0, change, order) >= best.rank:
                continue  # whatever comes of it, it is no better
            if order not in runs:
                if sum(one.steps for one in runs.values()) > MOST_STEPS:
                    is_whole = False
                    break
                runs[order] = self._run(order, change)
            best = min(best, runs[order], key=lambda one: one.rank)
        return Proposal(
            tuple(self._jobs(present, best)),
            self._digest,
            present.late_ms / 1000,
            best.late_ms / 1000,
            len(runs),
            orders.count,
            is_whole,
            best.unknown,
        )

    def _begun(self) -> RunOn:
        """Return a run in which all has happened that is due at the moment."""
        run = self._begin()
        run.orchestrator.settle()
        return run

    def _run(self, order: Order, change: int) -> _Run:
        """Return what an order leads to."""
        names = [self._queue[at].job.id for at in order]
        with closing(self._begun()) as run:
            if order != tuple(sorted(order)):
                wanted = ask('queue.arrange', _BY, jobs=names, queue_digest=self._digest)
                answer = run.orchestrator.ask(wanted)
                assert answer.accepted, answer.message
            run.go_on(math.inf)
            ends_s = run.ends_s()
            unknown = {one: run.unknown(one) for one in run.state.jobs}
        late_ms = sum(too_late_ms(ends_s[one], due_s) for one, due_s in self._due(ends_s))
        return _Run(len(unknown), late_ms, change, order, ends_s, unknown, run.steps)

    def _due(self, ends_s: Mapping[str, float]) -> Iterator[tuple[str, float]]:
        for one in (*self._line, *self._queue):
            if one.job.id in ends_s:
                yield one.job.id, _due_s(one)

    def _waiting(self, present: _Run) -> Iterator[Waiting]:
        """Yield the jobs of the queue, each with the time that it took as things are."""
        ends_s, before_s, work_s = present.ends_s, self._line_ends_s(present), dict[str, float]()
        known = [one for one in self._queue if one.job.id in ends_s]
        for one in sorted(known, key=lambda one: ends_s[one.job.id]):
            name = one.job.id
            work_s[name] = max(0.0, ends_s[name] - max(before_s, _start_s(one)))
            before_s = ends_s[name]
        for one in self._queue:
            name = one.job.id
            due_s = _due_s(one) if name in ends_s else math.inf
            priority, is_free = one.job.terms.priority, not _stays(one)
            yield Waiting(priority, is_free, due_s, _start_s(one), work_s.get(name, 0.0))

    def _line_ends_s(self, present: _Run) -> float:
        """Return when the last job on the line ends, as far as that is known."""
        ends_s = present.ends_s
        return max((ends_s.get(one.job.id, 0.0) for one in self._line), default=self._now_s)

    def _jobs(self, present: _Run, best: _Run) -> Iterator[ProposedJob]:
        queue = [(at + 1, place, self._queue[at]) for place, at in enumerate(best.order, start=1)]
        for place, new_place, one in (*((0, 0, one) for one in self._line), *queue):
            name, terms = one.job.id, one.job.terms
            ends_s, new_ends_s = (self._from_now(run.ends_s.get(name)) for run in (present, best))
            stays = _stays(one) if place else ''
            yield ProposedJob(
                name, place, new_place, terms.priority, terms.due, ends_s, new_ends_s, stays
            )

    def _from_now(self, ends_s: float | None) -> float | None:
        return None if ends_s is None else ends_s - self._now_s


def _stays(job: JobState) -> str:
    """Say why a job of the queue keeps its place; empty: it may get another one."""
    if job.aborting:
        return 'it is being aborted'
    lacks = [words for cause, words in obstacles(job) if cause is not StandCause.JOB_START]
    if lacks:
        return f'it {" and ".join(lacks)}'
    return '' if job.ranked else 'its place was chosen'


def _due_s(job: JobState) -> float:
    return math.inf if job.job.terms.due is None else job.job.terms.due


def _start_s(job: JobState) -> float:
    """Return before when it does not start."""
    start = job.job.terms.start
    return start if job.awaits_start and start is not None else -math.inf
