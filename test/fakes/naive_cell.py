"""A second opinion on the rules: the cell as docs/semantics.md tells it, without a tree.

Written from the page, not from the product; numbers are those of its rules. A round visits
initialization, then the sections from the last to the first, then the belt; rounds follow until
nothing changes, then time moves on. Yields the records of docs/events.md, without words for
people and without goal ids.
"""

from __future__ import annotations

from dataclasses import replace

from fakes.naive_queue import NaiveQueue
from fakes.naive_run import Item, Job, Task
from fakes.naive_verdicts import needs_belt


class NaiveCell(NaiveQueue):
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

    def is_due(self, number: int, item: Item) -> bool:
        """Tell whether a section has a list for an item and has not begun with it."""
        return number in item.job.plan.lists and not self.said('cycle.started', item.at(number))

    def before(self, job: Job) -> list[Job]:
        return [earlier for earlier in self.jobs[: self.jobs.index(job)] if self.is_able(earlier)]

    def done_with(self, number: int, job: Job) -> bool:
        """Tell whether a section is done with a job (6.1)."""
        to_come = any(0 < item.place < number for item in job.items)
        here = any(item.place == number and self.is_due(number, item) for item in job.items)
        in_hand = number in self.cycles and self.cycles[number].item.job is job
        return not (job.left or to_come or here or in_hand)

    def done_with_earlier(self, number: int, job: Job) -> bool:
        return all(self.done_with(number, earlier) for earlier in self.before(job))

    def end_job(self, job: Job) -> None:
        """End a job of which nothing remains (6.1)."""
        items = any(item.place for item in job.items)
        cycles = any(cycle.item.job is job for cycle in self.cycles.values())
        tasks = any(task.state != 'done' for task in job.first.values())
        if not (job.left or items or cycles or tasks):
            self.begin_job(job)
            self.jobs.remove(job)
            self.say('job.aborted' if job.aborting else 'job.completed', {'job': job})

    # --- initialization (5) -----------------------------------------------------------------

    def prepare(self, task: Task) -> None:
        """Let a task of an initialization go on (5.1, 5.2)."""
        job = task.job
        if task.state in ('new', 'waiting') and self.is_needless(task):
            self.carry_out(task, 'skip')
        is_set = self.is_change_needless(task)
        done = is_set or (task.given.get('once') and self.done.get(task.does) == task.args)
        first = [t for entry in self.before(job) for t in entry.first.values()]
        there = [entry for entry in first if entry.device is task.device]
        ordered = all(entry.state == 'done' for entry in [*there, *task.after])
        turn = ordered and all(self.done_with_earlier(n, job) for n in task.device.places)
        stays = self.stays_set if is_set else self.stays_done
        begins = self.may_begin() and (turn or (done and stays(task)))
        if task.state == 'new' and not (begins and self.may_be_begun(job)):
            return
        if done and task.state in ('new', 'waiting') and not self.stopped(None):
            self.begin_job(job)
            self.carry_out(task, 'skip')
        self.visit(task)

    def stays_done(self, task: Task) -> bool:
        """Tell whether a job could begin and nobody before it does a task again (5.1)."""
        before = self.before(task.job)
        again = [other for job in [*before, task.job] for other in job.first.values()]
        to_come = [other for other in again if other is not task and other.state != 'done']
        does = [other.does for other in to_come]
        for job in before:
            for number in [n for n in job.plan.lists if not self.done_with(n, job)]:
                steps = job.plan.lists[number]
                does += [(t['action'], t['task']) for step in steps for m in step for t in m]
        source = self.done_with_earlier(task.job.plan.source, task.job)
        return source and task.does not in does

    def prepared(self, number: int, job: Job) -> bool:
        """Tell whether a section may begin a cycle of a job (5.2)."""
        first = [task for earlier in self.before(job) for task in earlier.first.values()]
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
        is_new = not item
        if not item:
            item = self.new_item(job)
        self.cycles[number] = self.new_cycle(number, item, beat)
        self.last_beat[number] = beat
        self.begin_job(job)
        self.say('cycle.started', item.at(number), beat=beat)
        if is_new and job.asks and job.left and self.approves:
            job.paused, job.asks, job.piece = True, False, item
            self.say('job.paused', {'job': job, 'item': item})

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
        may = job and not job.paused and self.stop_after != 'item' and self.may_be_begun(job)
        ready = job and may and self.done_with_earlier(source, job) and self.prepared(source, job)
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
