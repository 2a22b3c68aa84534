"""The jobs that have not ended: those on the line, then the queue.

A queue may be very long, and a line queries it many times a second. So these queries take the same
time for any number of waiting jobs: which jobs are on the line, which one is next, whether any
still uses a script or a flag.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import (
    ItemsView,
    Iterable,
    Iterator,
    KeysView,
    Mapping,
    Sequence,
    ValuesView,
)
from contextlib import contextmanager
from itertools import chain

from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.state.job_state import JobState


class LiveJobs(dict[str, 'JobState']):
    """Jobs by id: those that have started, in the order they did, then the queue in its order.

    Only folds change it, by the methods below. A job in the queue is never changed in place but
    replaced by a copy, so an earlier list of the queue stays valid. A dict, since a task looks a
    job up twenty times; only its order is another one.
    """

    def __init__(self, jobs: Iterable[JobState] = ()) -> None:
        super().__init__()
        self.line: dict[str, JobState] = {}
        """Those that have started, in the order they did; read only."""
        self._keys: dict[str, float] = {}
        """Sort keys of the queue; a job put between two others gets a number between."""
        self._order: list[str] = []
        """The queue."""
        self._allowed: list[str] = []
        """Those in the queue that may start when it is their turn, in its order."""
        self._ranked: list[str] = []
        """Those in the queue whose places follow from their urgency, or from a proposal, in its
        order (semantics 6.7)."""
        self._mixed = 0
        """So many of them, from the first, may stand in front of more urgent ones, as it was
        proposed. Of the others the most urgent comes first."""
        self._awaiting: list[tuple[float, str]] = []
        """Those in the queue that wait for their start, with the time of it, by that time."""
        self._ending: set[str] = set()
        """Jobs in the queue that are being aborted: they skip their initialization, and end."""
        self._scripts: Counter[str] = Counter()
        """How many jobs use a script, by its digest."""
        self._flags: Counter[str] = Counter()
        """How many jobs name a flag."""
        for job in jobs:
            self.add(job)
        self._mixed = self._last_mixed()

    def __iter__(self) -> Iterator[str]:
        return chain(self.line, self._order)

    def keys(self) -> KeysView[str]:  # type: ignore[override]  # in their order
        """Return the ids."""
        return KeysView(self)

    def values(self) -> ValuesView[JobState]:  # type: ignore[override]
        """Return the jobs."""
        return ValuesView(self)

    def items(self) -> ItemsView[str, JobState]:  # type: ignore[override]
        """Return ids and jobs."""
        return ItemsView(self)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mapping) and list(self.items()) == list(other.items())

    __hash__ = None  # it changes

    # --- the queue --------------------------------------------------------------------------

    @property
    def waiting(self) -> int:
        """How many jobs are in the queue."""
        return len(self._order)

    @property
    def queued_names(self) -> Sequence[str]:
        """The queue, by id."""
        return self._order

    def queue(self, first: int = 1, most: int | None = None) -> list[JobState]:
        """Return jobs of the queue in order.

        :param first: place of the first one, from 1
        :param most: so many; None: all
        """
        names = self._order[first - 1 : None if most is None else first - 1 + most]
        return [self[name] for name in names]

    def place(self, name: str) -> int:
        """Return the place of a job in the queue, from 1; 0: it is not there."""
        return self._at(self._order, name) + 1 if name in self._keys else 0

    def place_for(self, urgency: tuple[int, float], but: str = '') -> int:
        """Return the place of a new job, from 1: before the first ranked one that is less urgent.

        :param but: a job in the queue that is treated as if it were not there
        """
        mixed, of = self._mixed, self._urgency
        at = bisect_right(self._ranked, urgency, mixed, key=of)
        late = (name for name in self._ranked[:mixed] if of(name) > urgency)
        behind = next((name for name in (*late, *self._ranked[at : at + 2]) if name != but), None)
        place = self.place(behind) if behind is not None else len(self._order) + 1
        return place - 1 if 0 < self.place(but) < place else place

    @property
    def first_awaiting(self) -> JobState | None:
        """The job in the queue whose start comes first, of those that wait for it."""
        return self[self._awaiting[0][1]] if self._awaiting else None

    @property
    def next(self) -> JobState | None:
        """The first job in the queue that may start."""
        return self[self._allowed[0]] if self._allowed else None

    def first(self, most: int) -> list[JobState]:
        """Return the jobs on the line, and the first ones of the queue."""
        return [*self.line.values(), *self.queue(most=most)]

    # --- queries of the line ----------------------------------------------------------------

    @property
    def any_allowed(self) -> bool:
        """Tell whether any job is on the line, ends, or may start in its turn."""
        return bool(self.line or self._ending or self._allowed)

    def at_work(self) -> list[JobState]:
        """Return the jobs that can do anything, in order.

        These are the started ones and, from the queue, the next one and those being aborted. All
        others wait until the next one has begun all of its items (semantics 5.2, 6.1).
        """
        queued = sorted((*self._ending, *self._allowed[:1]), key=self._keys.__getitem__)
        return [*self.line.values(), *map(self.__getitem__, queued)]

    def before(self, name: str) -> Iterator[JobState]:
        """Yield the jobs in front of one; those that may not start are passed (semantics 6.6)."""
        for job in self.line.values():
            if job.job.id == name:
                return
            yield job
        key = self._keys[name]
        allowed = self._allowed[: self._at(self._allowed, name)]
        ending = (other for other in self._ending if self._keys[other] < key)
        for queued in sorted((*ending, *allowed), key=self._keys.__getitem__):
            yield self[queued]

    def users(self, digest: str) -> int:
        """Return how many jobs use a script."""
        return self._scripts[digest]

    def names_flag(self, flag: str) -> bool:
        """Tell whether the script of any job names a flag."""
        return flag in self._flags

    # --- changes ----------------------------------------------------------------------------

    def add(self, job: JobState, place: int | None = None) -> None:
        """Take a job in, behind those on the line or in the queue.

        :param place: the one in the queue that it gets, from 1; None: the last
        """
        name = job.job.id
        self._count(job, 1)
        self[name] = job
        if job.started:
            self.line[name] = job
            return
        self._put(name, place)

    def move(self, name: str, place: int, *, ranked: bool = False) -> None:
        """Give a job in the queue another place, from 1.

        :param ranked: it is the one that follows from its urgency
        """
        job = self._take(name)
        self[name] = changed(job, ranked=ranked)
        self._put(name, place)

    def arrange(self, names: Sequence[str]) -> None:
        """Put the first jobs of the queue into another order."""
        keys = [self._keys[name] for name in self._order[: len(names)]]
        self._keys.update(zip(names, keys, strict=True))
        for each in (self._order, self._allowed, self._ranked):
            each.sort(key=self._keys.__getitem__)
        self._mixed = self._last_mixed()

    def start(self, name: str, time: float) -> None:
        """Take a job out of the queue, behind those on the line; held ones in front stay."""
        job = self._take(name)
        self[name] = self.line[name] = changed(
            job, started_at=time, progress=changed(job.progress), items=dict(job.items)
        )

    @contextmanager
    def changing(self, name: str) -> Iterator[JobState]:
        """Replace a job in the queue; meanwhile it uses no script and no flag."""
        self._count(self.queued(name), -1)
        self._await(name, waits=False)
        job = self[name] = changed(self.queued(name))
        yield job
        self._judge(name)
        self._count(job, 1)

    def hold(self, name: str, *, held: bool) -> None:
        """Let later jobs pass a job in the queue, or let it start in its turn again."""
        self[name] = changed(self.queued(name), held=held)
        self._judge(name)

    def lack(self, name: str, unavailable: tuple[str, ...]) -> None:
        """Note which components out of service a job in the queue needs."""
        self[name] = changed(self.queued(name), unavailable=unavailable)
        self._judge(name)

    def release_script(self, name: str) -> None:
        """Release a queued job from the wait for the release of its script."""
        self[name] = changed(self.queued(name), awaits_release=False)
        self._judge(name)

    def allow_start(self, name: str) -> None:
        """Release a queued job from its start: it may begin at once."""
        self._await(name, waits=False)
        self[name] = changed(self.queued(name), awaits_start=False)
        self._judge(name)

    def abort(self, name: str, reason: str) -> None:
        """Let a job end."""
        queued = self[name] if name in self._keys else None
        if queued is not None:
            self._await(name, waits=False)
            nothing = {'awaits_start': False, 'awaits_release': False, 'unavailable': ()}
            self[name] = changed(queued, **nothing)
        job = self[name]
        job.aborting, job.paused, job.held, job.end_reason = True, False, False, reason
        job.piece = ''
        if queued is not None:
            self._judge(name)

    def remove(self, name: str) -> JobState:
        """Take a job out and return it."""
        job = self.pop(name) if self.line.pop(name, None) else self._take(name)
        self._count(job, -1)
        return job

    def queued(self, name: str) -> JobState:
        """Return a job in the queue."""
        assert name in self._keys, f'{name} is not in the queue'
        return self[name]

    def _put(self, name: str, place: int | None) -> None:
        last = len(self._order) + 1
        at = last if place is None else place
        assert 1 <= at <= last, f'there is no place {at} in the queue'
        self._keys[name] = self._key_at(at - 1)
        self._order.insert(at - 1, name)
        self._judge(name)

    def _key_at(self, at: int) -> float:
        """Return a key that sorts between the job now at a place and the one before it."""
        if not self._order:
            return 0.0
        if at == 0:
            return self._keys[self._order[0]] - 1.0
        if at == len(self._order):
            return self._keys[self._order[-1]] + 1.0
        before, after = self._keys[self._order[at - 1]], self._keys[self._order[at]]
        between = (before + after) / 2
        if before < between < after:
            return between
        self._keys = {name: float(number) for number, name in enumerate(self._order)}
        return at - 0.5

    def _take(self, name: str) -> JobState:
        job = self.queued(name)
        for names in (self._allowed, self._ranked):
            self._list(names, name, is_one=False)
        self._await(name, waits=False)
        self._ending.discard(name)
        del self._order[self._at(self._order, name)], self[name], self._keys[name]
        return job

    def _judge(self, name: str) -> None:
        """Update the lists that a job in the queue is in."""
        job = self[name]
        if job.aborting:
            self._ending.add(name)
        self._list(self._allowed, name, is_one=job.may_start)
        self._list(self._ranked, name, is_one=job.ranked)
        self._await(name, waits=job.awaits_start)

    def _list(self, names: list[str], name: str, *, is_one: bool) -> None:
        at = self._at(names, name)
        is_there = names[at : at + 1] == [name]
        if is_one == is_there:
            return
        if names is self._ranked and at < self._mixed:
            self._mixed += 1 if is_one else -1
        names[at : at + is_there] = [name] * is_one

    def _urgency(self, name: str) -> tuple[int, float]:
        return self[name].job.terms.urgency

    def _last_mixed(self) -> int:
        """Return the place of the last ranked job that is more urgent than the one before it."""
        ranked = list(map(self._urgency, self._ranked))
        return next((at for at in range(len(ranked) - 1, 0, -1) if ranked[at - 1] > ranked[at]), 0)

    def _await(self, name: str, *, waits: bool) -> None:
        """Note whether a job in the queue waits for its start, which does not change meanwhile."""
        start = self[name].job.terms.start
        if start is None:
            return
        at = bisect_left(self._awaiting, (start, name))
        is_there = self._awaiting[at : at + 1] == [(start, name)]
        if waits and not is_there:
            self._awaiting.insert(at, (start, name))
        elif is_there and not waits:
            del self._awaiting[at]

    def _at(self, names: list[str], name: str) -> int:
        return bisect_left(names, self._keys[name], key=self._keys.__getitem__)

    def _count(self, job: JobState, number: int) -> None:
        for counts, key in (
            (self._scripts, job.digest),
            *((self._flags, dependency.flag) for dependency in job.job.script.dependencies),
        ):
            counts[key] += number
            if not counts[key]:
                del counts[key]
