"""What becomes of the tasks of the naive cell, and what its operators say about them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection
from typing import Any

from fakes.naive_plan import Row
from fakes.naive_run import LAST, Item, Job, Task
from fakes.naive_setups import NaiveSetups, read_change
from fakes.naive_verdicts import answers, is_skipped, refuses, serial_in, verdict

GRACE_S = 5.0
OF_CANCEL = {'timeout': 'timeout', 'abort': 'in_doubt', '': 'in_doubt'}
"""What it means that a goal was cancelled, by who asked for it; '': a stranger (2.3, 2.6, 7.2)."""


class NaiveTasks(NaiveSetups):
    """A cell that does what is to be done about each task."""

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
        needs = task.needs | {task.device.name}
        free = not any(needs & other.needs for other in busy)
        free &= task.device.name not in self.out and not self.is_changing(task)
        if free and self.now >= task.not_before and not self.is_untold(task):
            task.attempt += 1
            lacks = list(self.lacking(task))
            if missing or lacks:
                self.end(task, 'missing_result' if missing else 'setup_missing')
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
        task.needs = task.needs | {task.device.name}
        task.goals, task.sent = task.goals + 1, (self.deliveries, next(self.numbers))
        others = [other for other in self.started if other.state != 'done' and other is not task]
        self.started = [*others, task]
        action, name = task.does
        self.done.pop(task.does, None)
        self.note_change(task, done=False)
        fields: Row = {'name': name, 'action': action, 'component': task.device.name}
        fields['round'] = task.round or None
        self.say('task.started', task.where, attempt=task.attempt, **fields)
        deaf_after_s, ends = task.device.take(name)
        task.deaf_from = round(self.now + deaf_after_s, 6)
        timeout_s = {'timeout': 300.0, **task.device.given, **task.given}['timeout']
        self.at(timeout_s, task, 'timeout', LAST)
        for seconds, end, certain in ends:
            is_accepted = end != 'goal_rejected'
            self.at(seconds, task, end, (self.now + certain, is_accepted))

    def cancel(self, task: Task, cause: str) -> None:
        """Cancel a goal and await its end for a while (2.4); `abort` does so once more (7.2)."""
        if task.state == 'running' and (cause == 'abort' or not task.cancelled):
            task.cancelled = cause
            self.say('task.cancel_requested', task.where, cause=cause)
            task.awaited_until = round(self.now + GRACE_S, 6)
            self.at(GRACE_S, task, 'in_doubt', LAST)
            if self.now < task.deaf_from:
                delivery, number = task.sent
                is_on_its_way = delivery == self.deliveries  # then its acceptance is awaited
                order = (self.now, is_on_its_way)
                self.at(0.0, task, 'canceled', order, number if is_on_its_way else None)

    def end(self, task: Task, end: str) -> None:
        """Let an attempt end with a reason or '' for success, or its time be over (2.2 to 2.4)."""
        if end == 'in_doubt' and self.now < task.awaited_until:
            return  # it was asked to end once more since
        results = task.device.results(task.given['task'])
        if not end and (changed := read_change(task)):
            self.note_told(task.device.name, *changed)
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
            if end == 'setup_missing':
                task.needs = task.needs - {task.device.name}
            fields = {'attempt': task.attempt, 'reason': task.reason, 'round': task.round or None}
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
        if done and task is not self.move:
            self.note_change(task, done=True)
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
        is_new = what == 'reject' and not task.item.rejected
        if what == 'reject':
            self.reject(task.item)
        if what == 'hold' or (what == 'abort_job' and task is self.move):
            if task.state != 'held':
                task.state = 'held'
                self.hold(task.reason, task.where, self.offered(task), task)
        elif what == 'retry':
            task.state, task.not_before = 'waiting', round(self.now + delay_s, 6)
            self.at(delay_s, task, 'retry', LAST)
            times = {'attempt': task.attempt + 1, 'not_before': task.not_before}
            self.say('task.retrying', task.where, **times)
        elif what == 'change':
            for change in [entry for entry in self.lacking(task) if entry.state == 'done']:
                self.carry_out(change, 'retry')
            self.carry_out(task, 'retry')
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
            if is_new:
                self.look_for_run(task.item)

    def look_for_run(self, item: Item) -> None:
        """Hold the line where a new reject makes too many of the items in a row (7.7)."""
        count, limit = self.count_of(item.job), item.job.plan.limit or self.limit or {}
        if item not in count.items:
            return
        count.rejects.append(item)
        for place, first in enumerate(count.items):
            in_a_row = count.items[place : place + limit['of']]
            run = [piece for piece in in_a_row if piece in count.rejects]
            if first in run and len(run) >= limit['rejects'] and not count.hold:
                ids = [piece.id for piece in run]
                self.hold('too_many_rejects', {'job': item.job}, ['resume'], items=ids)
                count.hold = self.holds[-1]

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
        needless = bool(task.job) and not task.item and self.is_needless(task)
        return answers(task, [item.job for item in self.slots().values()], needless=needless)

    def operate(self, answer: str, hold: Any = None, item: Item | None = None) -> None:
        """Do what an operator says; jobs on the belt are aborted and the move stays held (3.5)."""
        answered = hold if hold and (hold.task or answer == 'resume') else None
        self.say('operator.decided', {}, answer=answer, hold=answered, item=item)
        if item:
            self.take_out(item, 'by_hand')
        for entry in list(self.holds):
            meant = entry.answers == [answer] and entry.where.get('item') is item
            meant = meant and entry.reason != 'too_many_rejects'  # only its number releases it
            if meant or (entry is hold and (entry.task is not self.move or answer != 'abort_job')):
                self.holds.remove(entry)
                self.say('hold.released', {}, hold=entry)
                for count in self.counts.values():
                    if count.hold is entry:
                        count.hold, count.rejects = None, []
        if hold and hold.task:
            self.carry_out(hold.task, answer)
        if answer == 'pause':
            self.hold('paused', {}, ['resume'])

    # --- jobs and items (3, 4, 6) ---

    def begin_job(self, job: Job) -> None:
        """Let a job leave the queue, behind those that have started (6.1)."""
        if not self.has_begun(job):
            started = [other for other in self.jobs if self.has_begun(other)]
            self.jobs.remove(job)
            self.jobs.insert(len(started), job)
            self.say('job.started', {'job': job})

    def abort_jobs(self, jobs: Collection[Job]) -> None:
        """Abort jobs, in the order of the queue (3.5, 4.3)."""
        for job in [job for job in self.jobs if job in jobs and not job.aborting]:
            job.aborting, job.left, job.piece = True, 0, None
            self.say('job.aborting', {'job': job})
            for item in [item for item in job.items if item.place and not item.empty]:
                self.reject(item)
            for task in [candidate for candidate in self.started if candidate.job is job]:
                self.cancel(task, 'abort_job')

    def reject(self, item: Item) -> None:
        item.rejected = True
        self.say_once('item.rejected', {'job': item.job, 'item': item})

    def take_out(self, item: Item, how: str) -> None:
        """Take an item off the belt; before the sink it leaves an empty position (3.2)."""
        self.say('item.removed', item.at(item.place), how=how)
        self._facts.add((f'item.removed {how}', item))
        if item.place == item.job.plan.sink and how != 'by_hand':
            item.place = 0
        else:
            item.empty = True

    @abstractmethod
    def moved(self) -> None: ...

    @abstractmethod
    def is_needless(self, task: Task) -> bool: ...
