"""A second opinion on the rules: the cell as docs/semantics.md tells it, without a tree.

Written from the page, not from the product; numbers are those of its rules. A round visits
initialization, then the sections from the last to the first, then the belt; rounds follow until
nothing changes, then time moves on. Yields the records of docs/formats.md, without words for
people and without goal ids.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from math import inf
from typing import Any

from fakes.naive_plan import Row
from fakes.naive_run import Item, Job, Task
from fakes.naive_state import NaiveState
from fakes.naive_verdicts import answers, is_skipped, needs_belt, refuses, serial_in, verdict

GRACE_S = 5.0
CANCELED_FIRST, TIMES_LAST = -inf, inf
OF_CANCEL = {'timeout': 'timeout', 'abort': 'in_doubt', '': 'in_doubt'}
"""What it means that a goal was cancelled, by who asked for it; '': a stranger (2.3, 2.6, 7.2)."""


class NaiveCell(NaiveState):
    """One cell with its queue."""

    def settle(self) -> None:
        """Let everything happen that can at this time (4.4)."""
        seen = -1
        while seen != len(self.records):
            seen = len(self.records)
            for task in [task for job in self.able() for task in job.first.values()]:
                self.prepare(task)
            for number in reversed(self.sections):
                self.section(number)
            self.belt()
            for job in list(self.jobs):
                self.end_job(job)
            self.cell_state(still=seen == len(self.records))

    # --- jobs and items (6) -----------------------------------------------------------------

    def submit(
        self, id_: str, script: str, quantity: int, priority: int = 0, start: float | None = None
    ) -> None:
        known = [link['flag'] for one in self.jobs for link in one.plan.flags]
        job = self.new_job(id_, script, quantity)
        job.rank = (-priority, inf if start is None else start)
        job.early = start is not None and start > self.now
        self.flags |= {f['flag']: f['initial'] for f in job.plan.flags if f['flag'] not in known}
        queue = [one for one in self.jobs if not self.has_begun(one)]
        behind = next((one for one in queue if one.rank > job.rank), None)  # (6.7)
        at = self.jobs.index(behind) if behind else len(self.jobs)
        self.jobs.insert(at, job)
        place = queue.index(behind) + 1 if behind else None
        terms = {'priority': priority or None, 'start': start, 'awaits_start': job.early or None}
        lacks = self.lacks(job) or None
        what = {'script': script, 'quantity': quantity, 'position': place, **terms}
        self.say('job.queued', {'job': job}, **what, ranked=True, unavailable=lacks)
        if job.early:
            self.at(job.rank[1] - self.now, job, 'start', CANCELED_FIRST)
        self.had_work |= self.is_able(job)
        self.settle()

    def begin_job(self, job: Job) -> None:
        """Let a job leave the queue, behind those that have started (6.1)."""
        if not self.has_begun(job):
            started = [one for one in self.jobs if self.has_begun(one)]
            self.jobs.remove(job)
            self.jobs.insert(len(started), job)
            self.say('job.started', {'job': job})

    def is_due(self, number: int, item: Item) -> bool:
        """Tell whether a section has a list for an item and has not begun with it."""
        return number in item.job.plan.lists and not self.said('cycle.started', item.at(number))

    def before(self, job: Job) -> list[Job]:
        return [one for one in self.jobs[: self.jobs.index(job)] if self.is_able(one)]

    def done_with(self, number: int, job: Job) -> bool:
        """Tell whether a section is done with a job (6.1)."""
        to_come = any(0 < item.place < number for item in job.items)
        here = any(item.place == number and self.is_due(number, item) for item in job.items)
        in_hand = number in self.cycles and self.cycles[number].item.job is job
        return not (job.left or to_come or here or in_hand)

    def done_with_earlier(self, number: int, job: Job) -> bool:
        return all(self.done_with(number, one) for one in self.before(job))

    def end_job(self, job: Job) -> None:
        """End a job of which nothing remains (6.1)."""
        items = any(item.place for item in job.items)
        cycles = any(cycle.item.job is job for cycle in self.cycles.values())
        tasks = any(task.state != 'done' for task in job.first.values())
        if not (job.left or items or cycles or tasks):
            self.begin_job(job)
            self.jobs.remove(job)
            self.say('job.aborted' if job.aborting else 'job.completed', {'job': job})

    def abort_jobs(self, jobs: Collection[Job]) -> None:
        """Abort jobs, in the order of the queue (3.5, 4.3)."""
        for job in [job for job in self.jobs if job in jobs and not job.aborting]:
            job.aborting, job.left = True, 0
            self.say('job.aborting', {'job': job})
            for item in [item for item in job.items if item.place and not item.empty]:
                self.reject(item)
            for task in [one for one in self.started if one.job is job]:
                self.cancel(task, 'abort_job')

    def reject(self, item: Item) -> None:
        item.rejected = True
        self.say_once('item.rejected', {'job': item.job, 'item': item})

    def take_out(self, item: Item, how: str) -> None:
        """Take an item off the belt; before the sink it leaves an empty position (3.2)."""
        self.say('item.removed', item.at(item.place), how=how)
        if item.place == item.job.plan.sink and how != 'by_hand':
            item.place = 0
        else:
            item.empty = True

    # --- initialization (5) -----------------------------------------------------------------

    def prepare(self, task: Task) -> None:
        """Let a task of an initialization go on (5.1, 5.2)."""
        job = task.job
        if job.aborting and task.state in ('new', 'waiting'):
            self.carry_out(task, 'skip')
        done = task.given.get('once') and self.done.get(task.does) == task.args
        first = [t for one in self.before(job) for t in one.first.values()]
        there = [one for one in first if one.device is task.device]
        ordered = all(one.state == 'done' for one in [*there, *task.after])
        turn = ordered and all(self.done_with_earlier(n, job) for n in task.device.places)
        begins = self.may_begin() and (turn or (done and self.stays_done(task)))
        if task.state == 'new' and not begins:
            return
        if done and task.state in ('new', 'waiting') and not self.stopped(None):
            self.begin_job(job)
            self.carry_out(task, 'skip')
        self.visit(task)

    def stays_done(self, task: Task) -> bool:
        """Tell whether a job could begin and nobody before it does a task again (5.1)."""
        before = self.before(task.job)
        again = [one for job in [*before, task.job] for one in job.first.values()]
        to_come = [one for one in again if one is not task and one.state != 'done']
        does = [one.does for one in to_come]
        for job in before:
            for number in [n for n in job.plan.lists if not self.done_with(n, job)]:
                steps = job.plan.lists[number]
                does += [(t['action'], t['task']) for step in steps for m in step for t in m]
        source = self.done_with_earlier(task.job.plan.source, task.job)
        return source and task.does not in does

    def prepared(self, number: int, job: Job) -> bool:
        """Tell whether a section may begin a cycle of a job (5.2)."""
        first = [task for one in self.before(job) for task in one.first.values()]
        if any(number in task.device.places and task.state != 'done' for task in first):
            return False
        for task in [task for task in job.first.values() if task.state != 'done']:
            behind = max(task.waits_for) > min(task.device.places)
            if number in task.device.places or (number == job.plan.source and behind):
                return False
        return True

    # --- sections and belt (3) --------------------------------------------------------------

    def section(self, number: int) -> None:
        """Go through the steps of a section's cycle as far as it gets (3.1, 3.3, 3.7, 3.8)."""
        if number not in self.cycles:
            self.begin(number)
            return
        cycle = self.cycles[number]
        rests = self.beat >= cycle.beat and not self.moving
        for n, step in enumerate(cycle.steps):
            if number in cycle.item.job.plan.early and not any(map(needs_belt, cycle.steps[n:])):
                self.say_once('turn.completed', cycle.where)
            may_begin = rests or not needs_belt(step)
            ended = [all(self.visit(task, may_begin) for task in member) for member in step]
            if not all(ended):
                return
        del self.cycles[number]
        self.say_once('turn.completed', cycle.where)
        self.say('cycle.completed', cycle.where)

    def begin(self, number: int) -> None:
        """Begin a section's next cycle, perhaps ahead of its beat."""
        job, item, beat = self.next_cycle(number)
        if not job or not self.may_begin() or not self.prepared(number, job):
            return
        if not item:
            item = self.new_item(job)
        self.cycles[number] = self.new_cycle(number, item, beat)
        self.last_beat[number] = beat
        self.begin_job(job)
        self.say('cycle.started', item.at(number), beat=beat)

    def next_cycle(self, number: int) -> tuple[Job | None, Item | None, int]:
        """Return job, item (None: a new one), beat of a section's next cycle (3.4, 3.7, 6.1)."""
        beat = self.beat + self.moving
        item = self.slots().get(number - self.moving)
        if item and self.is_due(number, item):
            return item.job, item, beat
        if self.last_beat[number] >= beat or (item and not self.moving):
            beat += 1
        job = self.source_job()
        in_the_way = [n for n, cycle in self.cycles.items() if cycle.beat - n >= beat - number]
        if not job or job.plan.source != number or beat > self.beat + 1 or in_the_way:
            return None, None, 0
        return job, None, beat

    def source_job(self) -> Job | None:
        """Return the job that the source may work on (5.2, 6.1)."""
        job = next((job for job in self.able() if job.left), None)
        source = job.plan.source if job else 0
        ready = job and self.done_with_earlier(source, job) and self.prepared(source, job)
        return job if ready else None

    def belt(self) -> None:
        """Move, or begin a beat without a move, once every turn is complete."""
        if self.moving:
            self.visit(self.move)
            return
        if any(map(self.has_turn, self.sections)):
            return
        last = self.slots().get(self.sections[-1])
        if last and not last.empty:
            if not self.said('hold.raised', last.at(last.place)):
                self.hold('overrun', last.at(last.place), ['remove_item'])
        elif self.slots() and self.may_begin() and 'conveyor' in self.out:
            return
        elif self.slots() and self.may_begin():
            self.moving = True
            self.say('belt.index_started', {}, beat=self.beat)
            self.move = replace(self.move, state='new', attempt=0)
            self.visit(self.move)
        elif self.may_begin():
            ahead = any(cycle.beat > self.beat for cycle in self.cycles.values())
            if ahead or self.source_job():
                self.beat += 1
                self.say('beat.started', {}, beat=self.beat)

    def has_turn(self, number: int) -> bool:
        """Tell whether a section still has its turn in this beat (3.4)."""
        cycle = self.cycles.get(number)
        if cycle and cycle.beat <= self.beat and not self.said('turn.completed', cycle.where):
            return True
        return self.next_cycle(number)[2] == self.beat

    def moved(self) -> None:
        for place, item in reversed(self.slots().items()):
            ends = place == self.sections[-1]
            item.place = 0 if ends else place + 1
            self.say('position.ended' if ends else 'item.moved', item.at(item.place or place))
        self.moving, self.beat = False, self.beat + 1
        self.say('belt.indexed', {}, beat=self.beat)

    # --- tasks (2, 4) -----------------------------------------------------------------------

    def visit(self, task: Task, may_begin: bool = True) -> bool:
        """Let a task go on as far as it can; tell whether it had ended, or is skipped."""
        if task.state == 'failed':
            self.decide(task)
            return False
        if task.state not in ('new', 'waiting') or self.stopped(task.section):
            return task.state == 'done'
        if task.state == 'new' and not (may_begin and self.flags_allow(task)):
            return False
        missing = False
        try:
            if task.item and is_skipped(task.given, task.item):
                self.carry_out(task, 'skip')
                return True
        except KeyError:
            missing = True
        busy = [other for other in self.started if other.busy and other is not task]
        free = not any(task.needs & other.needs for other in busy)
        free &= task.device.name not in self.out
        if free and self.now >= task.not_before:
            task.attempt += 1
            if missing:
                self.end(task, 'missing_result')
                self.decide(task)
            else:
                self.start(task)
        return False

    def flags_allow(self, task: Task) -> bool:
        """Tell whether no flag of a task would sink below 0 or rise above its capacity (4.1)."""
        changes = task.job.plan.changes[task.id] if task.item else ()
        return all(0 <= self.flags[flag] + step <= most for flag, step, most in changes)

    def start(self, task: Task) -> None:
        if task.job:
            self.begin_job(task.job)
        task.state, task.cancelled, task.busy = 'running', '', True
        task.goals, task.sent = task.goals + 1, (self.deliveries, next(self.numbers))
        self.last_sent = self.deliveries
        others = [one for one in self.started if one.state != 'done' and one is not task]
        self.started = [*others, task]
        action, name = task.does
        self.done.pop(task.does, None)
        fields: Row = {'name': name, 'action': action, 'component': task.device.name}
        if task.repeat and task.repeat.begun:
            fields['round'] = task.repeat.begun
        self.say('task.started', task.where, attempt=task.attempt, **fields)
        deaf_after_s, ends = task.device.take(name)
        task.deaf_from = round(self.now + deaf_after_s, 6)
        timeout_s = {'timeout': 300.0, **task.device.given, **task.given}['timeout']
        self.at(timeout_s, task, 'timeout', TIMES_LAST)
        for seconds, end, certain in ends:
            self.at(seconds, task, end, certain)

    def cancel(self, task: Task, cause: str) -> None:
        """Cancel a goal and await its end for a while (2.4); `abort` does so once more (7.2)."""
        if task.state == 'running' and (cause == 'abort' or not task.cancelled):
            task.cancelled = cause
            self.say('task.cancel_requested', task.where, cause=cause)
            task.awaited_until = round(self.now + GRACE_S, 6)
            self.at(GRACE_S, task, 'in_doubt', TIMES_LAST)
            if self.now < task.deaf_from:
                delivery, number = task.sent
                is_on_its_way = delivery == self.deliveries  # then the cancel comes behind it
                is_behind = self.last_sent == self.deliveries  # so it does behind any other goal
                certain = 0.0 if is_behind else CANCELED_FIRST
                self.at(0.0, task, 'canceled', certain, number if is_on_its_way else None)

    def end(self, task: Task, end: str) -> None:
        """Let an attempt end with a reason or '' for success, or its time be over (2.2 to 2.4)."""
        if end == 'in_doubt' and self.now < task.awaited_until:
            return  # it was asked to end once more since
        results = task.device.results(task.given['task'])
        refused = not end and task is not self.move and refuses(task, results)
        end = 'result_refused' if refused else end
        serial = '' if end else serial_in(task, results)
        if serial in self.serials and serial != task.item.serial:
            end = 'duplicate_serial'
        if end == 'timeout':
            self.cancel(task, 'timeout')
        elif end:
            task.refused = results if end in ('result_refused', 'duplicate_serial') else {}
            means = OF_CANCEL if end == 'canceled' else {}
            task.state, task.reason = 'failed', means.get(task.cancelled, end)
            asks = ('hold', 'abort_job') if task is self.move else ('hold',)
            task.busy &= verdict(task) in asks
            fields = {'attempt': task.attempt, 'reason': task.reason}
            self.say('task.failed', task.where, **fields, results=task.refused or None)
        else:
            self.say('task.succeeded', task.where, attempt=task.attempt, results=results or None)
            self.executed(task, results)

    def executed(self, task: Task, results: Row | None) -> None:
        """Change flags, quantity and item; no results at all: it was not done (2.7, 3.2, 4.2)."""
        done, item, change = results is not None, task.item, task.given.get('qty_change')
        task.state, task.busy = 'done', False
        if task is self.move:
            self.moved()
        elif item:
            item.remember(task, results or {})
            for flag, step, _ in item.job.plan.changes[task.id]:
                self.flags[flag] += step
                event = 'flag.raised' if step > 0 else 'flag.lowered'
                self.say(event, task.where, flag=flag, count=self.flags[flag])
        if done:
            self.done.pop(task.does, None)
        if done and task in self.started:
            self.done[task.does] = task.args
        serial = serial_in(task, results)
        if serial and serial != item.serial:
            item.serial = serial
            self.serials.add(serial)
            where = {'job': task.job, 'item': item, 'task': task}
            self.say('item.identified', where, serial=serial)
        if change == 1:
            item.placed, item.empty = True, not done
            lots = {name: item.value(lot) for name, lot in item.job.plan.lots.items()}
            event = 'item.placed' if done else 'item.missing'
            self.say(event, item.at(task.section), lots=(done and lots) or None)
        elif change == -1 and done and not item.empty:
            self.take_out(item, 'rejected' if item.rejected else 'packed')
        elif change == -1 and item.empty and task.section == item.place == item.job.plan.sink:
            item.place = 0
            self.say('position.ended', item.at(task.section))

    # --- failures and operators (2.6, 2.7, 7.1) -------------------------------------------

    def decide(self, task: Task) -> None:
        """Do what is to be done about a failed attempt; nothing that is stopped begins a round."""
        if verdict(task) == 'again' and self.stopped(task.section):
            return
        self.carry_out(task, verdict(task), task.given.get('retry_delay', 0.0))

    def carry_out(self, task: Task, what: str, delay_s: float = 0.0) -> None:
        """Do what a rule, a policy or an operator says about a task; a move is never given up."""
        if what == 'abort_job':
            self.abort_jobs([task.job] if task.job else [i.job for i in self.slots().values()])
        if what == 'reject':
            self.reject(task.item)
        if what == 'hold' or (what == 'abort_job' and task is self.move):
            if task.state != 'held':
                task.state = 'held'
                self.hold(task.reason, task.where, self.offered(task), task)
        elif what == 'retry':
            task.state, task.not_before = 'waiting', round(self.now + delay_s, 6)
            self.at(delay_s, task, 'retry', TIMES_LAST)
            times = {'attempt': task.attempt + 1, 'not_before': task.not_before}
            self.say('task.retrying', task.where, **times)
        elif what == 'again':
            self.begin_round(task.repeat, task.where)
        elif what in ('mark_done', 'skip'):
            if task.state == 'held' and 'fails_unless' in task.given and not task.item.empty:
                self.say('item.nonconforming', {'job': task.job, 'item': task.item, 'task': task})
            self.say('task.skipped' if what == 'skip' else 'task.marked_done', task.where)
            self.executed(task, {} if what == 'mark_done' else None)
        else:
            self.say('task.continued', task.where, policy=what)
            self.executed(task, None)
            if what == 'continue' and task.refused:
                task.item.remember(task, task.refused)

    def begin_round(self, repeat: Any, where: Row) -> None:
        """Do the tasks of a repeat once more (3.9)."""
        repeat.begun += 1
        ids = [task.id for task in repeat.tasks]
        cycle = {key: where[key] for key in ('job', 'section', 'item')}
        self.say('round.begun', cycle, repeat=ids[0], n=repeat.begun, tasks=ids)
        for task in repeat.tasks:
            task.state, task.attempt, task.busy, task.not_before = 'new', 0, False, 0.0
            where['item'].forget(task)

    def offered(self, task: Task) -> list[str]:
        """Return what makes sense as an answer about a held task now (7.1)."""
        return answers(task, [item.job for item in self.slots().values()])

    def operate(self, answer: str, hold: Any = None, item: Item | None = None) -> None:
        """Do what an operator says; jobs on the belt are aborted and the move stays held (3.5)."""
        self.say('operator.decided', {}, answer=answer, hold=hold, item=item)
        if item:
            self.take_out(item, 'by_hand')
        for one in list(self.holds):
            meant = one.answers == [answer] and one.where.get('item') is item
            if meant or (one is hold and (one.task is not self.move or answer != 'abort_job')):
                self.holds.remove(one)
                self.say('hold.released', {}, hold=one)
        if hold:
            self.carry_out(hold.task, answer)
        if answer == 'pause':
            self.hold('paused', {}, ['resume'])
