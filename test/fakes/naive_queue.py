"""What operators ask of the jobs of the naive cell (6.6, 6.7, 7.2)."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from fakes.drawn.plan import UPDATES
from fakes.naive_run import FIRST, Item, Job, Task
from fakes.naive_tasks import NaiveTasks

Asked = tuple[str, str]
"""What is asked, of which job."""


class NaiveQueue(NaiveTasks):
    """A cell with orders, which are placed, held, moved, changed, paused, stopped and aborted."""

    @property
    def queue(self) -> list[Job]:
        """The jobs that have not started, in order."""
        return [job for job in self.jobs if not self.has_begun(job)]

    def submit(
        self,
        id_: str,
        script: str,
        quantity: int,
        priority: int = 0,
        start: float | None = None,
        by_recipe: bool = False,
        setup: float = 0.0,
    ) -> None:
        """Take an order."""
        job = self.taken(id_, script, quantity)
        job.values['params.setup'] = setup
        job.by_recipe = by_recipe
        self.jobs.append(job)
        job.terms, job.rank = (priority, start), rank_of(priority, start)
        job.early = self.is_to_come(start)
        place = self.place(job)
        self.say('job.queued', {'job': job}, **self.told(job), position=place, ranked=True)
        self.wait_for_start(job)
        self.had_work |= self.is_able(job)
        self.settle()

    def taken(self, id_: str, script: str, quantity: int) -> Job:
        """Return a new job; flags that no other one has begin anew (4.1)."""
        known = [link['flag'] for live_job in self.jobs for link in live_job.plan.flags]
        job = self.new_job(id_, script, quantity)
        self.flags |= {f['flag']: f['initial'] for f in job.plan.flags if f['flag'] not in known}
        return job

    def told(self, job: Job) -> dict[str, object]:
        """Return what the record of an order says of it."""
        (priority, start), made = job.terms, job.plan.made_from
        return {
            'script': job.plan.name,
            'quantity': job.left,
            'priority': priority or None,
            'start': start,
            'awaits_start': job.early or None,
            'recipe': made.get('recipe'),
            'recipe_version': made.get('version'),
            'awaits_release': self.is_unreleased(job) or None,
            'unavailable': self.lacks(job) or None,
        }

    def place(self, job: Job) -> int | None:
        """Put a job of the queue where its rank says; None: that is the end (6.7)."""
        self.jobs.remove(job)
        rank, queue = rank_of(*job.terms), self.queue
        less_urgent = (n for n, other in enumerate(queue, 1) if other.rank and other.rank > rank)
        place = next(less_urgent, None)
        self.put(job, len(queue) + 1 if place is None else place)
        return place

    def put(self, job: Job, position: int) -> None:
        """Put a job that is not in the queue at a position, from 1."""
        at = len(self.jobs) - len(self.queue) + position - 1
        self.jobs.insert(at, job)

    def is_to_come(self, start: float | None) -> bool:
        return start is not None and start > self.now

    def wait_for_start(self, job: Job) -> None:
        start = job.terms[1]
        if job.early and start is not None:
            job.waits += 1
            self.at(start - self.now, job, f'start {job.waits}', FIRST, job.id)

    # --- what can be asked --------------------------------------------------------------------

    def possible(self) -> list[Asked]:
        """Return what can be asked of each job now, by docs/queue.md."""
        return [(what, job.id) for job in self.jobs for what in sorted(self._possible(job))]

    def _possible(self, job: Job) -> list[str]:
        if not self.has_begun(job):
            free = [
                *(['release'] if job.held or job.early else []),
                *([] if job.held else ['hold']),
            ]
            return ['move', 'next', 'update', *free, 'abort', 'cancel']
        if job.aborting:
            return []
        if job.stopping:
            return ['abort']
        runs = ['pause'] if not job.paused and self.state == 'Execute' and not self.holds else []
        rest = ['requeue'] if job.by_recipe and job.left else []
        approved = not job.piece or self.said('item.removed packed', {'item': job.piece})
        goes_on = ['resume'] if approved else []
        refused = ['another'] if job.piece else []
        return [*(goes_on if job.paused else runs), *refused, 'stop', 'abort', *rest]

    def ask(self, what: str, name: str, number: int) -> None:
        """Do what an operator asks of a job.

        :param number: for its new place, or its new terms
        """
        job = next(candidate for candidate in self.jobs if candidate.id == name)
        self.say('operator.decided', {}, answer=what, job=job)
        getattr(self, f'_{what}')(job, number)
        self.settle()

    def _hold(self, job: Job, _: int) -> None:
        job.held = True
        self.say('job.held', {'job': job})

    def _release(self, job: Job, _: int) -> None:
        """Take the hold away; of a job that is not held, the wait for its start (6.7)."""
        if job.held:
            job.held = False
            self.say('job.released', {'job': job})
        else:
            job.early = False
            self.say('job.may_start', {'job': job})
        self.had_work |= self.is_able(job)

    def _next(self, job: Job, _: int) -> None:
        self._move(job, 1)
        while job.held or job.early:
            self._release(job, 0)

    def _move(self, job: Job, position: int) -> None:
        """Put a job where a person wants it: it is not compared any more (6.7)."""
        self.jobs.remove(job)
        position = min(position, len(self.queue) + 1)
        job.rank = None
        self.put(job, position)
        self.say('job.moved', {'job': job}, position=position)

    def _update(self, job: Job, number: int) -> None:
        """Change an order: another quantity, perhaps another script, priority or start (6.6)."""
        change, job.by_recipe = UPDATES[number % len(UPDATES)], False
        before, job.left = job.terms, change.quantity
        job.terms = (change.priority, change.start or before[1])
        scripts = list(self.plans)
        if change.script:
            self.exchange(job, scripts[number % len(scripts)])
        if job.terms[1] != before[1]:
            job.early = self.is_to_come(job.terms[1])
            self.wait_for_start(job)
        place = None
        if job.terms != before and job.rank is not None:
            job.rank = rank_of(*job.terms)
            self.place(job)
            place = self.queue.index(job) + 1
        self.say('job.updated', {'job': job}, **self.told(job), position=place)
        self.had_work |= self.is_able(job)

    def exchange(self, job: Job, script: str) -> None:
        """Let a job of the queue have another script."""
        new = self.taken(job.id, script, job.left)
        job.plan, job.first, job.needs = new.plan, new.first, new.needs
        job.asks = new.asks
        for task in job.first.values():
            task.job = job

    def _cancel(self, job: Job, _: int) -> None:
        job.early = False
        self.jobs.remove(job)
        self.say('job.removed', {'job': job})

    def _pause(self, job: Job, _: int) -> None:
        job.paused = True
        self.say('job.paused', {'job': job})

    def _resume(self, job: Job, _: int) -> None:
        piece, job.paused, job.piece = job.piece, False, None
        self.say('job.resumed', {'job': job}, item=piece)

    def _another(self, job: Job, _: int) -> None:
        """Refuse a first piece: the next item is another one (6.12)."""
        piece, job.paused, job.piece, job.asks = job.piece, False, None, True
        self.say('job.resumed', {'job': job}, item=piece, another=True)

    def _stop(self, job: Job, _: int) -> None:
        piece, job.stopping, job.left, job.piece = job.piece, True, 0, None
        self.say('job.stopping', {'job': job}, item=piece)

    def _requeue(self, job: Job, _: int) -> None:
        """Stop a job, and queue what it has not begun in front of all others (7.6)."""
        rest = self.taken(f'{job.id}-rest', job.plan.name, job.left)
        rest.by_recipe, rest.terms, rest.rank = True, job.terms, None
        rest.values = {**job.values, 'order.id': rest.id}
        self._stop(job, 0)
        self.put(rest, 1)
        fields = {**self.told(rest), 'position': 1, 'rest_of': job}
        self.say('job.queued', {'job': rest}, **fields)
        self.had_work |= self.is_able(rest)

    def _abort(self, job: Job, _: int) -> None:
        """Abort a job; one that has not started ends at once (6.6)."""
        self.abort_jobs([job])
        if not self.has_begun(job):
            for task in job.first.values():
                self.carry_out(task, 'skip')
            job.early = False
            self.jobs.remove(job)
            self.say('job.aborted', {'job': job})

    def arrange(self, names: Sequence[str]) -> None:
        """Put jobs into another order at the places that they have together (6.7)."""
        jobs = {job.id: job for job in self.queue}
        places = sorted(self.jobs.index(jobs[name]) for name in names)
        for place, name in zip(places, names, strict=True):
            self.jobs[place] = jobs[name]
        self.say('operator.decided', {}, answer='arrange')
        self.say('queue.arranged', {}, jobs=[job.id for job in self.queue])
        self.settle()

    # --- the line runs empty (6.6) --------------------------------------------------------------

    def ways_to_empty(self) -> list[str]:
        """Return after what the line can be told to stop now; `never`: that can be taken back."""
        begun = any(map(self.has_begun, self.jobs))
        return [*(['item', 'job'] if begun else []), *(['never'] if self.stop_after else [])]

    def run_empty(self, after: str) -> None:
        """Let the line run empty, or take that back."""
        self.say('operator.decided', {}, answer=f'stop_after_{after}')
        if after == 'never':
            self.stop_after = ''
            self.say('queue.stop_cancelled', {})
        else:
            self.stop_after = after
            self.say('queue.stop_requested', {}, after=after)
        self.settle()

    def may_be_begun(self, job: Job) -> bool:
        """Tell whether a job has begun, or may: not on a line that runs empty."""
        return self.has_begun(job) or not self.stop_after

    def ends_empty(self) -> bool:
        """Tell whether the line was to run empty, and has, and no task of a job is held."""
        if any(hold.where.get('job') for hold in self.holds):
            return False
        left: list[Item] | list[Job] = [
            item for job in self.jobs for item in job.items if item.place
        ]
        if self.stop_after == 'job':
            left = [job for job in self.jobs if self.has_begun(job)]
        return bool(self.stop_after) and not left

    # --- what it means ------------------------------------------------------------------------

    def is_needless(self, task: Task) -> bool:
        """Tell whether a job that ends early needs an initialization task no more (6.6)."""
        job = task.job
        items = any(item.place for item in job.items)
        cycles = any(cycle.item.job is job for cycle in self.cycles.values())
        return bool(job.aborting or (job.stopping and not (items or cycles)))


def rank_of(priority: int, start: float | None) -> tuple[int, float]:
    """Return how urgent an order is: the smaller the more (6.7)."""
    return -priority, inf if start is None else start
