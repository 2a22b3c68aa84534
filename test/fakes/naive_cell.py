"""A second opinion on the rules: the cell as docs/semantics.md tells it, without a tree.

Written from the page, not from the product. A round visits initialization, then the sections from
the last to the first, then the belt; rounds follow until nothing changes, then time moves on.
Yields the records of docs/formats.md, without words for people and without goal ids.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

from fakes.naive_devices import NaiveDevices
from fakes.naive_plan import (
    Hold,
    Item,
    Job,
    MissingResult,
    Row,
    Work,
    needs_belt,
    plan_of,
    task_row,
    value_of,
    wanted,
)

GRACE_S = 5.0
PASSING = {'Resetting': 'Idle', 'Starting': 'Execute', 'Unholding': 'Execute'}
PASSING |= {'Completing': 'Complete'}


class NaiveCell:
    """One cell with its queue."""

    def __init__(
        self, cell: Row, scripts: Sequence[Row], duration: Callable[[str, int], float | None]
    ) -> None:
        self.devices = NaiveDevices(cell, duration)
        self.size = cell['conveyor']['sections']
        self.plans = {s['script']: plan_of(s, self.devices.by_action) for s in scripts}
        keys = ('task', 'action', 'retries', 'on_failure')
        move = {key: cell['conveyor'][key] for key in keys if key in cell['conveyor']}
        self.move = Work(task_row(move, 'index', self.devices.by_action[move['action']]))
        self.now, self.beat, self.moving, self.state, self.paused = 0.0, 1, False, 'Stopped', False
        self.records: list[Row] = []
        self.jobs: list[Job] = []
        numbers = range(1, self.size + 1)
        self.slots: dict[int, Item | None] = dict.fromkeys(numbers)
        self.cycles: dict[int, Any] = dict.fromkeys(numbers)
        self.last_beat = dict.fromkeys(numbers, 0)
        self.flags: dict[str, int] = {}
        self.work: dict[Any, Work] = {}
        self.running: list[Work] = []
        self.holds: dict[str, Hold] = {}
        self.taken: dict[str, Work] = {}
        self.once: set[str] = set()
        self.agenda: list[Any] = []
        self.unsent: list[Work] = []
        self.notes, self.hold_ids = itertools.count(), itertools.count(1)

    # --- time -------------------------------------------------------------------------------

    def advance(self, until: float) -> None:
        """Let everything happen up to a time."""
        self.settle()
        while self.live() and self.agenda and self.agenda[0][0] <= until:
            self.now, due = self.agenda[0][0], []
            while self.agenda and self.agenda[0][0] == self.now:
                due.append(heapq.heappop(self.agenda)[2:])
            for what, work, attempt, reason in sorted(due, key=lambda one: one[0] != 'end'):
                if work.state == 'running' and work.attempt == attempt:
                    self.happen(what, work, reason)
            self.settle()
        self.now = round(max(self.now, until), 6) if self.live() else self.now

    def at(self, after: float, what: str, work: Work, reason: str = '', rank: int = 0) -> None:
        """Note what happens to an attempt after a while; of one time the lower rank is first."""
        order = rank * 10**9 + next(self.notes)
        time = round(self.now + after, 6)
        heapq.heappush(self.agenda, (time, order, what, work, work.attempt, reason))

    def happen(self, what: str, work: Work, reason: str) -> None:
        if what == 'timeout':
            self.cancel(work, 'timeout')
        elif what == 'grace':
            self.fail(work, 'in_doubt')
        elif reason:
            late = reason == 'canceled' and work.cause == 'timeout'
            self.fail(work, 'timeout' if late else reason)
        elif what == 'end':
            self.succeed(work)

    def settle(self) -> None:
        seen = -1
        while seen != len(self.records):
            seen = len(self.records)
            for job in self.live():
                for task in job.plan['first']:
                    self.prepare(self.of(task, job))
            for number in range(self.size, 0, -1):
                self.section(number)
            self.belt()
            self.endings()
            self.cell_state(still=seen == len(self.records))
        for work in self.unsent:
            self.at(work.task['timeout'], 'timeout', work)
            work.deaf, ends = self.devices.answers(work.task, cancelled=bool(work.cause))
            for seconds, reason, rank in ends:
                self.at(seconds, 'end', work, reason, rank)
        self.unsent = []

    def say(self, event: str, where: Row | None = None, **fields: Any) -> None:
        row = {'time': round(self.now, 6), 'event': event, **(where or {}), **fields}
        self.records.append({name: value for name, value in row.items() if value is not None})

    # --- the queue (6.1) --------------------------------------------------------------------

    def submit(self, id_: str, script: str, quantity: int) -> None:
        plan = self.plans[script]
        known = [link['flag'] for job in self.live() for link in job.plan['flags']]
        self.jobs.append(Job(id_, plan, quantity))
        self.say('job.queued', {'job': id_}, script=script, quantity=quantity)
        for link in plan['flags']:
            if link['flag'] not in known:
                self.flags[link['flag']] = link['initial']
        self.settle()

    def live(self) -> list[Job]:
        return [job for job in self.jobs if not job.over]

    def begins(self, job: Job | None) -> None:
        if job is not None and not job.started:
            job.started = True
            self.say('job.started', {'job': job.id})

    def done(self, number: int, job: Job) -> bool:
        """Tell whether a section is done with a job."""
        if job.left:
            return False
        for place in range(1, number + 1):
            cycle, item = self.cycles[place], self.slots[place]
            here = cycle.item if cycle and cycle.item.job is job else None
            if here and (place == number or not (here.standing or here.gone)):
                return False
            owed = number in job.plan['lists'] and item and number not in item.handled
            if item and item.job is job and (place < number or owed):
                return False
        return True

    def done_with_earlier(self, number: int, job: Job) -> bool:
        return all(self.done(number, one) for one in self.jobs[: self.jobs.index(job)])

    def endings(self) -> None:
        for job in self.live():
            there = [i for i in self.slots.values() if i]
            there += [cycle.item for cycle in self.cycles.values() if cycle]
            first = [self.of(task, job) for task in job.plan['first']]
            remains = any(i.job is job for i in there) or any(w.state != 'done' for w in first)
            if not job.left and not remains:
                job.over = True
                self.begins(job)
                self.say('job.aborted' if job.aborting else 'job.completed', {'job': job.id})

    def abort_job(self, job: Job) -> None:
        """Start no new source cycle, reject what there is, cancel what runs (4.3)."""
        if not job.aborting:
            job.aborting = True
            self.say('job.aborting', {'job': job.id})
            for item in job.items:
                if not item.empty:
                    self.reject(item)
            for work in self.running:
                if work.job is job:
                    self.cancel(work, 'abort_job')

    def reject(self, item: Item) -> None:
        if not item.rejected:
            item.rejected = True
            self.say('item.rejected', {'job': item.job.id, 'item': item.id})

    # --- initialization (5) -----------------------------------------------------------------

    def prepare(self, work: Work) -> None:
        job, task = work.job, work.task
        assert job is not None
        needless = job.aborting or (task['once'] and self.once_key(work) in self.once)
        if work.state in ('new', 'waiting') and needless and not self.stopped(None):
            self.say('task.skipped', work.where)
            work.state = 'done'
        if work.state == 'new':
            before = [self.of(one, job).state for one in job.plan['first'] if one in task['after']]
            earlier = all(self.done_with_earlier(n, job) for n in self.places(task))
            if not earlier or set(before) - {'done'} or self.state != 'Execute' or self.holds:
                return
        self.visit(work)

    def once_key(self, work: Work) -> str:
        return repr((work.task['action'], work.task['task'], sorted(work.task['args'].items())))

    def places(self, task: Row) -> Sequence[int]:
        return self.devices.by_action[task['action']]['places'] or range(1, self.size + 1)

    def prepared(self, number: int, job: Job) -> bool:
        """Tell whether a section may begin a job's first cycle (5.2)."""
        for task in job.plan['first']:
            if self.of(task, job).state != 'done':
                behind = max(self.waits_for(task)) > min(self.places(task))
                if number in self.places(task) or (number == job.plan['source'] and behind):
                    return False
        return True

    def waits_for(self, task: Row) -> set[int]:
        return set(self.places(task)).union(*map(self.waits_for, task['after']))

    # --- sections (3) -----------------------------------------------------------------------

    def section(self, number: int) -> None:
        cycle = self.cycles[number]
        if cycle is None:
            self.begin(number)
            return
        item, steps = cycle.item, cycle.item.job.plan['lists'][number]
        where = {'job': item.job.id, 'section': number, 'item': item.id}
        last = max([n for n, step in enumerate(steps) if needs_belt(step)], default=-1)
        while True:
            early = item.job.plan['early'][number] and cycle.step > last
            if (early or cycle.step == len(steps)) and number not in item.turned:
                item.turned.add(number)
                self.say('turn.completed', where)
            if cycle.step == len(steps):
                break
            if not self.step(number, cycle, steps[cycle.step]):
                return
            cycle.step += 1
        item.handled.add(number)
        self.cycles[number] = None
        self.say('cycle.completed', where)

    def step(self, number: int, cycle: Any, step: list[list[Row]]) -> bool:
        """Let a step go on; tell whether all its members ended."""
        rests, ended = not self.moving and self.beat >= cycle.beat, True
        for member in step:
            for task in member:
                work = self.of(task, cycle.item.job, number, cycle.item)
                if work.state == 'new' and needs_belt(step) and not rests:
                    return False
                if not self.visit(work):
                    ended = False
                    break
        return ended

    def begin(self, number: int) -> None:
        if self.state != 'Execute' or self.holds:
            return
        job, item, beat = self.next_of(number)
        if job is None or not self.prepared(number, job):
            return
        if item is None:
            job.begun += 1
            item = Item(job, job.begun)
            job.items.append(item)
        self.begins(job)
        self.last_beat[number] = beat
        self.cycles[number] = SimpleNamespace(item=item, beat=beat, step=0)
        where = {'job': job.id, 'section': number, 'item': item.id}
        self.say('cycle.started', where, beat=beat)

    def next_of(self, number: int) -> tuple[Job | None, Item | None, int]:
        """Return job, item (None at the source) and beat of a section's next cycle (3.4, 3.7)."""
        item = self.slots.get(number - 1 if self.moving else number)
        to_come = self.beat + 1 if self.moving else self.beat
        if item and number != item.job.plan['source'] and self.owes(number, item.handled, item):
            return item.job, item, to_come
        job = self.source_job(number)
        taken = not self.moving and self.slots[number] is not None
        if taken or self.last_beat[number] >= to_come:
            to_come += 1
        fits = job and to_come <= self.beat + 1 and self.is_behind_all(number, to_come)
        return (job, None, to_come) if fits else (None, None, 0)

    def is_behind_all(self, number: int, beat: int) -> bool:
        """Tell whether a new item stands behind every one that is worked on (6.1)."""
        return all(c.beat - n < beat - number for n, c in self.cycles.items() if c)

    def owes(self, number: int, marks: set[int], item: Item) -> bool:
        return number in item.job.plan['lists'] and number not in marks

    def source_job(self, number: int) -> Job | None:
        job = next((job for job in self.live() if job.left), None)
        if job is None or job.plan['source'] != number:
            return None
        return job if self.done_with_earlier(number, job) else None

    # --- tasks (2) --------------------------------------------------------------------------

    def of(
        self, task: Row, job: Job, section: int | None = None, item: Item | None = None
    ) -> Work:
        key = (job.id, section, item and item.id, task['id'])
        return self.work.setdefault(key, Work(task, job, section, item))

    def visit(self, work: Work) -> bool:
        """Let a task go on as far as it can; tell whether it ended."""
        before = work.state
        if before == 'failed':
            self.decide(work)
        elif before in ('new', 'waiting') and not self.stopped(work.section):
            return self.try_start(work)
        return before == 'done'

    def stopped(self, number: int | None) -> bool:
        """Tell whether a pause or a hold keeps a section from starting anything (7.1)."""
        places = [h.where.get('section') for h in self.holds.values() if 'job' in h.where]
        return self.paused or number in places

    def try_start(self, work: Work) -> bool:
        """Start a task, if nothing is in its way; tell whether it was skipped."""
        task, missing = work.task, False
        if work.item is not None:
            if work.state == 'new' and not self.flags_allow(work):
                return False
            try:
                skipped = not self.passes(work)
                for value in () if skipped else task['args'].values():
                    value_of(value, work.item)
            except MissingResult:
                skipped, missing = False, True
            if skipped:
                self.say('task.skipped', work.where)
                self.executed(work, done=False)
                return True
        names = [task['device'], *(f'zone {zone}' for zone in task['zones'])]
        if self.now < work.after or any(name in self.taken for name in names):
            return False
        work.attempt += 1
        if missing:
            self.fail(work, 'missing_result')
            self.decide(work)
            return False
        self.begins(work.job)
        work.state, work.cause, work.deaf = 'running', '', True
        self.running.append(work)
        self.unsent.append(work)
        self.taken |= dict.fromkeys(names, work)
        fields = {'name': task['task'], 'action': task['action'], 'component': task['device']}
        self.say('task.started', work.where, attempt=work.attempt, **fields)
        return False

    def flags_allow(self, work: Work) -> bool:
        for link in work.links:
            if (
                link['upstream'] == work.task['id']
                and self.flags[link['flag']] >= link['capacity']
            ):
                return False
            if link['downstream'] == work.task['id'] and self.flags[link['flag']] == 0:
                return False
        return True

    def passes(self, work: Work) -> bool:
        """Tell whether a task is not skipped (3.2, 6.4, 6.5)."""
        assert work.item is not None
        if work.item.empty and work.item.gone != 'sink':
            return False
        state = 'rejected' if work.item.rejected else 'good'
        return work.task['runs_for'] in (state, 'all') and wanted(work.task, work.item)

    def executed(self, work: Work, *, done: bool) -> None:
        """Change flags, quantity and item as a task that ended does (2.7, 3.2, 4.2)."""
        work.state, item, number = 'done', work.item, work.section
        for side, event, change in (('upstream', 'raised', 1), ('downstream', 'lowered', -1)):
            for link in work.links:
                if link[side] == work.task['id']:
                    self.flags[link['flag']] += change
                    fields = {'flag': link['flag'], 'count': self.flags[link['flag']]}
                    self.say(f'flag.{event}', work.where, **fields)
        if item is None or number is None:
            return
        place = {'job': item.job.id, 'section': number, 'item': item.id}
        if work.task['qty_change'] == 1:
            item.standing, item.missing, self.slots[number] = True, not done, item
            self.say('item.placed' if done else 'item.missing', place)
        if work.task['qty_change'] == -1:
            if done and not item.empty:
                self.take_out(item, number, 'rejected' if item.rejected else 'packed')
            elif item.empty and self.slots[number] is item and number == item.job.plan['sink']:
                self.slots[number] = None
                self.say('position.ended', place)

    def take_out(self, item: Item, number: int, how: str) -> None:
        at_sink = number == item.job.plan['sink'] and how != 'by_hand'
        item.gone = 'sink' if at_sink else 'early'
        if at_sink:
            self.slots[number] = None
        where = {'job': item.job.id, 'section': number, 'item': item.id}
        self.say('item.removed', where, how=how)

    def cancel(self, work: Work, cause: str) -> None:
        if not work.cause:
            work.cause = cause
            self.say('task.cancel_requested', work.where, cause=cause)
            self.at(GRACE_S, 'grace', work)
            if not work.deaf:
                self.at(0.0, 'end', work, 'canceled', -2)

    def free(self, work: Work) -> None:
        self.taken = {name: one for name, one in self.taken.items() if one is not work}

    def succeed(self, work: Work) -> None:
        self.running.remove(work)
        self.free(work)
        results = self.devices.results(work.task)
        self.say('task.succeeded', work.where, attempt=work.attempt, results=results or None)
        self.effects(work, results)

    def effects(self, work: Work, results: Row) -> None:
        if work is self.move:
            self.moved()
            return
        if work.item is None:
            self.once.add(self.once_key(work))
        elif results:
            work.item.results[work.task['id']] = results
        self.executed(work, done=True)

    def fail(self, work: Work, reason: str) -> None:
        self.running = [one for one in self.running if one is not work]
        work.state, work.reason = 'failed', reason
        if reason not in ('in_doubt', 'server_lost'):
            self.free(work)
        self.say('task.failed', work.where, attempt=work.attempt, reason=reason)

    # --- failures and operators (2.6, 2.7, 7.1) ---------------------------------------------

    def decide(self, work: Work) -> None:
        lost = work.reason == 'server_lost' and not work.task['repeatable']
        if work.reason == 'in_doubt' or lost:
            self.hold(work)
        elif work.cause == 'abort_job':
            self.go_on(work, 'abort_job')
        elif work.attempt <= work.task['retries'] and work.reason != 'missing_result':
            self.retry(work, work.task['retry_delay'])
        elif work.task['policy'] == 'hold':
            self.hold(work)
        else:
            self.go_on(work, work.task['policy'])

    def retry(self, work: Work, delay_s: float) -> None:
        self.free(work)
        work.state, work.after = 'waiting', round(self.now + delay_s, 6)
        self.at(delay_s, 'wake', work)
        fields = {'attempt': work.attempt + 1, 'not_before': work.after}
        self.say('task.retrying', work.where, **fields)

    def go_on(self, work: Work, policy: str) -> None:
        if policy == 'abort_job':
            self.abort_jobs_of(work)
        if policy == 'reject' and work.item:
            self.reject(work.item)
        if work is self.move:
            self.hold(work)
            return
        self.free(work)
        self.say('task.continued', work.where, policy=policy)
        self.executed(work, done=False)

    def abort_jobs_of(self, work: Work) -> None:
        """Abort the job of a task; of the belt's move every job on it, in their order (3.5)."""
        on_belt = [item.job for item in self.slots.values() if item]
        for job in self.live():
            if job is work.job or (work is self.move and job in on_belt):
                self.abort_job(job)

    def hold(self, work: Work) -> None:
        work.state = 'held'
        answers = ['retry', 'mark_done', 'skip', 'reject', 'abort_job']
        if work.task['qty_change'] == -1 or work is self.move:
            answers.remove('skip')
        if work.item is None:
            answers.remove('reject')
        self.raise_hold(Hold(work.where, work.reason, answers, work))

    def raise_hold(self, hold: Hold) -> None:
        id_ = str(next(self.hold_ids))
        self.holds[id_] = hold
        self.say('hold.raised', hold.where, hold=id_, reason=hold.reason, answers=hold.answers)

    def release(self, hold_id: str) -> None:
        del self.holds[hold_id]
        self.say('hold.released', hold=hold_id)

    def answer(self, hold_id: str, answer: str) -> None:
        work = self.holds[hold_id].work
        assert work is not None
        self.say('operator.decided', answer=answer, hold=hold_id)
        if work is self.move and answer == 'abort_job':
            self.abort_jobs_of(work)
        else:
            self.release(hold_id)
            self.carry_out(work, answer)
        self.settle()

    def carry_out(self, work: Work, answer: str) -> None:
        if answer == 'retry':
            self.retry(work, 0.0)
        elif answer == 'mark_done':
            self.free(work)
            self.say('task.marked_done', work.where)
            self.effects(work, {})
        elif answer == 'skip':
            self.free(work)
            self.say('task.skipped', work.where)
            self.executed(work, done=False)
        else:
            self.go_on(work, answer)

    def remove(self, item_id: str) -> None:
        """Take an item off the belt by hand."""
        for number, item in self.slots.items():
            if item and item.id == item_id and not item.empty:
                self.say('operator.decided', item=item_id, answer='remove_item')
                self.take_out(item, number, 'by_hand')
                for id_, hold in list(self.holds.items()):
                    if hold.reason == 'overrun' and hold.where['item'] == item_id:
                        self.release(id_)
        self.settle()

    def pause(self, paused: bool) -> None:
        self.paused = paused
        self.say('operator.decided', answer='pause' if paused else 'resume')
        if paused:
            self.raise_hold(Hold({}, 'paused', ['resume']))
        else:
            for id_ in [id_ for id_, hold in self.holds.items() if hold.reason == 'paused']:
                self.release(id_)
        self.settle()

    # --- the belt (3.4 to 3.6) --------------------------------------------------------------

    def belt(self) -> None:
        if self.moving:
            self.visit(self.move)
            return
        if any(map(self.pending, self.slots)):
            return
        last = self.slots[self.size]
        if last is not None and not last.empty:
            where = {'job': last.job.id, 'section': self.size, 'item': last.id}
            if all(hold.where != where for hold in self.holds.values()):
                self.raise_hold(Hold(where, 'overrun', ['remove_item']))
        elif self.state == 'Execute' and not self.holds:
            if any(self.slots.values()):
                self.moving = True
                self.say('belt.index_started', beat=self.beat)
                self.move = Work(self.move.task)
                self.visit(self.move)
            elif self.source_goes_on():
                self.beat += 1
                self.say('beat.started', beat=self.beat)

    def source_goes_on(self) -> bool:
        """Tell whether the source has a cycle for the next beat, begun ahead or to come."""
        if any(cycle and cycle.beat > self.beat for cycle in self.cycles.values()):
            return True
        return any((job := self.source_job(n)) and self.prepared(n, job) for n in self.slots)

    def pending(self, number: int) -> bool:
        """Tell whether a section still has its turn in this beat."""
        item, cycle = self.slots[number], self.cycles[number]
        if item and self.owes(number, item.turned, item):
            return True
        if cycle and cycle.beat <= self.beat and number not in cycle.item.turned:
            return True
        job = self.source_job(number)
        if job is None or item or self.last_beat[number] >= self.beat:
            return False
        return self.is_behind_all(number, self.beat) and (
            job.begun > 0 or self.prepared(number, job)
        )

    def moved(self) -> None:
        self.move.state = 'done'
        for number in range(self.size, 0, -1):
            item, self.slots[number] = self.slots[number], None
            if item is not None:
                ends = number == self.size
                place = number if ends else number + 1
                self.slots[place] = None if ends else item
                where = {'job': item.job.id, 'section': place, 'item': item.id}
                self.say('position.ended' if ends else 'item.moved', where)
        self.moving, self.beat = False, self.beat + 1
        self.say('belt.indexed', beat=self.beat)

    # --- the cell's state (7.1, 7.2) --------------------------------------------------------

    def cell_state(self, *, still: bool) -> None:
        """Make one transition, if one is due."""
        passing = dict(PASSING)
        if self.live():
            passing |= {'Stopped': 'Resetting', 'Complete': 'Resetting', 'Idle': 'Starting'}
        else:
            passing['Execute'] = 'Completing'
        if self.holds:
            passing |= dict.fromkeys(('Execute', 'Starting', 'Unholding'), 'Holding')
            later = [w for w in [self.move, *self.work.values()] if w.state == 'waiting']
            if still and not self.running and all(work.after <= self.now for work in later):
                passing['Holding'] = 'Held'
        else:
            passing |= {'Holding': 'Held', 'Held': 'Unholding'}
        if self.state in passing:
            state, self.state = self.state, passing[self.state]
            self.say('cell.state_changed', state=self.state, previous=state)
