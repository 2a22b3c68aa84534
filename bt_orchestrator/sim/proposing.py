"""An order for the queue: by priority, then by how late jobs end in runs of the engine (6.7)."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from heapq import nsmallest
from itertools import permutations, product
from types import MappingProxyType
from typing import NamedTuple

from bt_orchestrator.engine.runtime.stands import obstacles
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.state import JobState
from bt_orchestrator.model.state.proposed import queue_digest
from bt_orchestrator.model.wait import StandCause
from bt_orchestrator.model.words import joined
from bt_orchestrator.ports import Proposal, ProposedJob
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
    changeover_ms: int
    """Of all changes of setups between jobs."""
    change: int
    order: Order
    ends_s: Mapping[str, float]
    """On the clock of the state."""
    unknown: Mapping[str, str]
    """Why a job does not end."""
    steps: int

    @property
    def rank(self) -> tuple[int, int, int, int, Order]:
        """The key by which runs are compared."""
        return self[:5]


class Proposing:
    """Proposes an order for the queue of one moment."""

    def __init__(self, begin: Callable[[], RunOn], now_s: float) -> None:
        """Prepare.

        :param begin: returns a run from that moment
        :param now_s: the moment, on the clock of the state
        """
        self._begin, self._now_s = begin, now_s
        with closing(begin()) as run:  # before a cell that stands starts by itself, as runs do
            self._line = list(run.state.jobs.line.values())
            self._queue = run.state.jobs.queue(most=QUEUE_SHOWN)
            self._digest = queue_digest(run.state.jobs)
            self._cell = run.state.cell
            self._setups = self._setups_of(run)

    def propose(self) -> Proposal:
        """Return the best of the orders that are looked at."""
        present = self._run(tuple(range(len(self._queue))), 0)
        orders = QueueOrders(
            list(self._waiting(present)), self._line_ends_s(present), self._setups
        )
        runs, is_whole = {present.order: present}, orders.count <= FEW
        first, *others = orders.promising()
        best = present if first == present.order else self._run(first, orders.change(first))
        runs[first] = best
        is_guessed = self._change_by_themselves() or orders.any_waits
        for order in others:
            change = orders.change(order)
            least_ms = 0 if is_guessed else orders.changeover_ms(order)
            if (0, 0, least_ms, change, order) >= best.rank:
                continue  # whatever comes of it, it is no better
            if order not in runs:
                if sum(run.steps for run in runs.values()) > MOST_STEPS:
                    is_whole = False
                    break
                runs[order] = self._run(order, change)
            best = min(best, runs[order], key=lambda run: run.rank)
        return Proposal(
            tuple(self._jobs(present, best)),
            self._digest,
            present.late_ms / 1000,
            best.late_ms / 1000,
            len(runs),
            orders.count,
            is_whole,
            best.unknown,
            present.changeover_ms / 1000,
            best.changeover_ms / 1000,
        )

    def _run(self, order: Order, change: int) -> _Run:
        """Return what an order leads to."""
        names = [self._queue[at].job.id for at in order]
        with closing(self._begin()) as run:
            if order != tuple(sorted(order)):
                wanted = ask('queue.arrange', _BY, jobs=names, queue_digest=self._digest)
                answer = run.orchestrator.ask(wanted)
                assert answer.accepted, answer.message
            run.go_on(math.inf)
            ends_s = run.ends_s()
            unknown = {job: run.unknown(job) for job in run.state.jobs}
        late_ms = sum(too_late_ms(ends_s[job], due_s) for job, due_s in self._due(ends_s))
        changeover_ms = round(run.changeover_s * 1000)
        return _Run(
            len(unknown), late_ms, changeover_ms, change, order, ends_s, unknown, run.steps
        )

    def _due(self, ends_s: Mapping[str, float]) -> Iterator[tuple[str, float]]:
        for job in (*self._line, *self._queue):
            if job.job.id in ends_s:
                yield job.job.id, _due_s(job)

    def _waiting(self, present: _Run) -> Iterator[Waiting]:
        """Yield the jobs of the queue, each with the time that it took as things are."""
        ends_s, before_s, work_s = present.ends_s, self._line_ends_s(present), dict[str, float]()
        known = [job for job in self._queue if job.job.id in ends_s]
        for job in sorted(known, key=lambda job: ends_s[job.job.id]):
            name = job.job.id
            work_s[name] = max(0.0, ends_s[name] - max(before_s, _start_s(job)))
            before_s = ends_s[name]
        for job in self._queue:
            name = job.job.id
            due_s = _due_s(job) if name in ends_s else math.inf
            priority, is_free = job.job.terms.priority, not _stays(job)
            yield Waiting(
                priority, is_free, due_s, _start_s(job), work_s.get(name, 0.0), self._needs(job)
            )

    def _setups_of(self, run: RunOn) -> dict[tuple[str, str], str]:
        """Return the setups that the jobs on the line leave, as far as they are known."""
        setups = {
            (component, setup): entry.value
            for component, known in run.state.setups.items()
            for setup, entry in known.items()
        }
        for job in self._line:
            setups |= {which: value for which, (value, _) in self._needs(job).items()}
        return setups

    def _change_by_themselves(self) -> bool:
        """Tell whether a script changes a setup itself: it may leave any value."""
        return any(
            task.change is not None and not task.is_implied
            for job in (*self._line, *self._queue)
            for task in job.job.script.tasks.values()
        )

    def _needs(self, job: JobState) -> dict[tuple[str, str], tuple[str, float]]:
        """Return the values of setups that a job begins with, and the seconds of each change."""
        return {
            (task.component, task.change.setup): (
                task.change.value,
                self._cell.components[task.component].duration_s(task.name),
            )
            for task in job.job.script.initialization
            if task.change is not None and task.change.implied and not task.change.on_demand
        }

    def _line_ends_s(self, present: _Run) -> float:
        """Return when the last job on the line ends, as far as that is known."""
        ends_s = present.ends_s
        return max((ends_s.get(job.job.id, 0.0) for job in self._line), default=self._now_s)

    def _jobs(self, present: _Run, best: _Run) -> Iterator[ProposedJob]:
        queue = [(at + 1, place, self._queue[at]) for place, at in enumerate(best.order, start=1)]
        for place, new_place, job in (*((0, 0, job) for job in self._line), *queue):
            name, terms = job.job.id, job.job.terms
            ends_s, new_ends_s = (self._from_now(run.ends_s.get(name)) for run in (present, best))
            stays = _stays(job) if place else ''
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
        return joined(*lacks)
    return '' if job.ranked else 'its place was chosen'


def _due_s(job: JobState) -> float:
    return math.inf if job.job.terms.due is None else job.job.terms.due


def _start_s(job: JobState) -> float:
    """Return before when it does not start."""
    start = job.job.terms.start
    return start if job.awaits_start and start is not None else -math.inf


# Orders that the queue could have, the most promising ones first (semantics 6.7).
#
# What an order leads to is only guessed here: jobs one after the other, each for as long as it
# took in a run. The guess decides which orders the engine looks at first, and nothing else.

Order = tuple[int, ...]
"""Jobs by their present places, from 0, in another order."""

FEW = 720
"""Up to so many orders are all looked at."""

GUESSES = 10_000
"""Most orders of a longer queue that are guessed."""

KEPT = 500
"""Most of them that are returned, the most promising ones."""


class Waiting(NamedTuple):
    """A job of the queue."""

    priority: int
    is_free: bool
    """Whether it may get another place."""
    due_s: float
    """When it should have ended; infinite: not said."""
    start_s: float = -math.inf
    """Before that it does not start."""
    work_s: float = 0.0
    """How long it keeps the line."""
    needs: Mapping[tuple[str, str], tuple[str, float]] = MappingProxyType({})
    """By component and setup: the value that it begins with, and the seconds of a change."""


_Guess = tuple[int, int, int, Order]


class QueueOrders:
    """The orders of a queue in which jobs of a higher priority come first, in free places."""

    def __init__(
        self,
        jobs: Sequence[Waiting],
        begins_s: float = 0.0,
        setups: Mapping[tuple[str, str], str] = MappingProxyType({}),
    ) -> None:
        """Begin.

        :param begins_s: when the line has room for the first one
        :param setups: values then, by component and setup
        """
        self._setups = setups
        self._jobs = jobs
        self._begins_s = begins_s
        self.any_waits = any(job.start_s > begins_s for job in jobs)
        """Whether a job may be passed by later ones."""
        self._places = [at for at, job in enumerate(jobs) if job.is_free]
        alike: Mapping[int, list[int]] = defaultdict(list)
        for at in self._places:
            alike[jobs[at].priority].append(at)
        self._alike = [alike[priority] for priority in sorted(alike, reverse=True)]
        """Free jobs of one priority, the highest first."""
        self._guesses: dict[Order, _Guess] = {}

    @property
    def count(self) -> int:
        """How many orders there are."""
        return math.prod(math.factorial(len(jobs)) for jobs in self._alike)

    def promising(self) -> list[Order]:
        """Return orders, the most promising first; of few, all."""
        if self.count <= FEW:
            for parts in product(*map(permutations, self._alike)):
                self._guess(self._whole(sum(parts, ())))
        else:
            free = min(
                self._begins(), key=lambda order: (self._guess(self._whole(order))[:3], order)
            )
            self._improve(free)
            self._look_around()
        best = nsmallest(KEPT if self.count > FEW else FEW, self._guesses.values())
        return [order for *_, order in best]

    def change(self, order: Order) -> int:
        """Return by how many places all jobs together are moved."""
        return sum(abs(at - job) for at, job in enumerate(order))

    def _whole(self, free: Sequence[int]) -> Order:
        """Return an order with the free jobs in this one, and all others where they are."""
        order = list(range(len(self._jobs)))
        for at, job in zip(self._places, free, strict=True):
            order[at] = job
        return tuple(order)

    def _free(self, order: Order) -> list[int]:
        return [order[at] for at in self._places]

    def _begins(self) -> Iterator[list[int]]:
        """Yield orders of the free jobs to begin with: as now, and by when they are due."""
        jobs = self._jobs
        yield [at for alike in self._alike for at in alike]
        yield [at for alike in self._alike for at in sorted(alike, key=lambda at: jobs[at].due_s)]
        order, now_s = [], self._begins_s
        for alike in self._alike:
            left = list(alike)
            while left:  # what is due before it could be ready is judged by its length
                soonest = min(left, key=lambda at: max(jobs[at].due_s, now_s + jobs[at].work_s))
                left.remove(soonest)
                order.append(soonest)
                now_s += jobs[soonest].work_s
        yield order

    def _improve(self, free: list[int]) -> None:
        """Move one job after the other to where it does best, as long as that helps."""
        best, is_better = self._guess(self._whole(free)), True
        while is_better:
            is_better = False
            for at, to in self._moves():
                if len(self._guesses) >= GUESSES:
                    return
                other = free[:]
                other.insert(to, other.pop(at))
                guess = self._guess(self._whole(other))
                if guess < best:
                    free, best, is_better = other, guess, True

    def _look_around(self) -> None:
        """Move one job in the best orders, one after the other, also where it does not help."""
        seen = set[Order]()
        while left := self._guesses.keys() - seen:
            order = min(left, key=self._guesses.__getitem__)
            seen.add(order)
            for at, to in self._moves():
                if len(self._guesses) >= GUESSES:
                    return
                free = self._free(order)
                free.insert(to, free.pop(at))
                self._guess(self._whole(free))

    def _moves(self) -> Iterator[tuple[int, int]]:
        """Yield places among the free jobs, of one priority: from where, to where."""
        begin = 0
        for alike in self._alike:
            yield from permutations(range(begin, begin + len(alike)), 2)
            begin += len(alike)

    def _guess(self, order: Order) -> _Guess:
        """Return how bad an order is, and note it: late, and of changeover, in ms, and change."""
        known = self._guesses.get(order)
        if known is None:
            changeover_ms = self.changeover_ms(order)
            guess = (self._late_ms(order), changeover_ms, self.change(order), order)
            known = self._guesses[order] = guess
        return known

    def changeover_ms(self, order: Order) -> int:
        """Return the time of all changes of setups, if jobs start in an order."""
        setups, seconds = dict(self._setups), 0.0
        for at in order:
            for which, (value, change_s) in self._jobs[at].needs.items():
                if setups.get(which) != value:
                    setups[which] = value
                    seconds += change_s
        return round(seconds * 1000)

    def _late_ms(self, order: Order) -> int:
        now_s, late_ms = self._begins_s, 0
        waiting = [self._jobs[at] for at in order]
        if not self.any_waits:
            for job in waiting:
                now_s += job.work_s
                late_ms += too_late_ms(now_s, job.due_s)
            return late_ms
        while waiting:
            soonest = min(waiting, key=lambda job: job.start_s)
            job = next((job for job in waiting if job.start_s <= now_s), soonest)
            waiting.remove(job)
            now_s = max(now_s, job.start_s) + job.work_s
            late_ms += too_late_ms(now_s, job.due_s)
        return late_ms


def too_late_ms(ends_s: float, due_s: float) -> int:
    """Return by how much an end is too late, in whole milliseconds."""
    return max(0, round((ends_s - due_s) * 1000)) if due_s < math.inf else 0
