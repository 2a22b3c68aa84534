"""A second opinion on the rules: the cell as docs/semantics.md tells it, without a tree.

Written from the page, not from the product: lists, dictionaries and rounds. A round visits
initialization, then the sections from the last to the first, then the belt; rounds follow until
nothing changes, then time moves on. Yields the records of docs/formats.md, without what only
people read (messages, words of reasons) and without goal ids.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from fakes.naive_plan import (
    MissingResult,
    Row,
    cell_rows,
    fault_of,
    needs_belt,
    script_rows,
    task_row,
    value_of,
    wanted,
)

INDEX = (None, None, None, 'index')
GRACE_S, CHECK_S, CHECKS_OF_A_REQUEST = 5.0, 2.0, 2


class NaiveCell:
    """One cell with its queue."""

    def __init__(
        self, cell: Row, scripts: Sequence[Row], duration: Callable[[str, int], float | None]
    ) -> None:
        self.cell = cell_rows(cell)
        self.devices = self.cell['devices']
        self.scripts = {script['script']: script_rows(script, self.cell) for script in scripts}
        self.params = {script['script']: script.get('params', {}) for script in scripts}
        self.belt_row = cell['conveyor']
        self.duration = duration
        self.size = self.cell['size']
        self.now, self.beat, self.moving, self.state, self.paused = 0.0, 1, False, 'Stopped', False
        self.records: list[Row] = []
        self.jobs: list[Row] = []
        self.slots: dict[int, Row | None] = dict.fromkeys(range(1, self.size + 1))
        self.cycles: dict[int, Row | None] = dict.fromkeys(range(1, self.size + 1))
        self.last_beat = dict.fromkeys(range(1, self.size + 1), 0)
        self.flags: dict[str, int] = {}
        self.work: dict[tuple[Any, ...], Row] = {}
        self.holds: dict[str, Row] = {}
        self.taken: dict[str, tuple[Any, ...]] = {}
        self.once: set[str] = set()
        self.counts: Counter[Any] = Counter()
        self.dead: set[str] = set()
        self.agenda: list[tuple[float, float, Row]] = []
        self.unsent: list[Row] = []
        self.hold_count = 0

    RANKS: ClassVar[dict[Any, int]] = {'canceled by us': -2, 'goal_rejected': -1, 'late': 1}

    # --- time -------------------------------------------------------------------------------

    def due(self) -> float | None:
        return self.agenda[0][0] if self.agenda else None

    def advance(self, until: float) -> bool:
        """Let everything happen up to a time; tell whether a job is left."""
        self.settle()
        while self.live() and self.agenda and self.agenda[0][0] <= until:
            self.now = self.agenda[0][0]
            late = []
            while self.agenda and self.agenda[0][0] == self.now:
                goal = heapq.heappop(self.agenda)[2]
                if goal.get('limit'):
                    late.append(goal)
                else:
                    self.goal_ended(goal)
            for limit in late:
                self.limit_reached(limit)
            self.settle()
        self.now = round(max(self.now, until), 6) if self.live() else self.now
        return bool(self.live())

    def at(self, time: float, what: Row) -> None:
        """Note what happens at a time; of one time a refusal is told first."""
        self.counts['agenda'] += 1
        rank = self.counts['agenda'] + 1e9 * self.RANKS.get(what.get('rank', what.get('end')), 0)
        heapq.heappush(self.agenda, (round(time, 6), rank, what))

    def settle(self) -> None:
        seen = -1
        while seen != len(self.records):
            seen = len(self.records)
            self.initialization()
            for number in range(self.size, 0, -1):
                self.section(number)
            self.belt()
            self.endings()
            self.cell_state(seen)
        for goal in self.unsent:
            self.arrive(goal)
        self.unsent = []

    def say(self, event: str, key: Sequence[Any] = (), **fields: Any) -> None:
        named = dict(zip(('job', 'section', 'item', 'task'), key, strict=False))
        row = {'time': round(self.now, 6), 'event': event, **named, **fields}
        self.records.append({name: value for name, value in row.items() if value is not None})

    # --- the queue --------------------------------------------------------------------------

    def submit(self, id_: str, script: str, quantity: int) -> None:
        plan = self.scripts[script]
        live = [d['flag'] for job in self.live() for d in job['plan']['flags']]
        params = {name: row.get('default') for name, row in self.params[script].items()}
        job = {'id': id_, 'plan': plan, 'quantity': quantity, 'begun': 0, 'params': params}
        self.jobs.append({**job, 'started': False, 'aborting': False, 'over': False})
        self.say('job.queued', (id_,), script=script, quantity=quantity)
        for link in plan['flags']:
            if link['flag'] not in live:
                self.flags[link['flag']] = link['initial']
        self.settle()

    def live(self) -> list[Row]:
        return [job for job in self.jobs if not job['over']]

    def begins(self, job: Row | None) -> None:
        if job is not None and not job['started']:
            job['started'] = True
            self.say('job.started', (job['id'],))

    def left(self, job: Row) -> int:
        return 0 if job['aborting'] else job['quantity'] - job['begun']

    def done(self, number: int, job: Row) -> bool:
        """Tell whether a section is done with a job (6.1)."""
        if self.left(job):
            return False
        for place in range(1, number + 1):
            cycle, item = self.cycles[place], self.slots[place]
            here = cycle['item'] if cycle and cycle['job'] is job else None
            if here and (place == number or not (here['standing'] or here['gone'])):
                return False
            owed = number in job['plan']['lists'] and item and number not in item['handled']
            if item and item['job'] is job and (place < number or owed):
                return False
        return True

    def done_with_earlier(self, number: int, job: Row) -> bool:
        return all(self.done(number, one) for one in self.jobs[: self.jobs.index(job)])

    def endings(self) -> None:
        for job in self.live():
            first = [self.of((job['id'], None, None, t['id'])) for t in job['plan']['first']]
            there = [i for i in self.slots.values() if i] + [c for c in self.cycles.values() if c]
            if (
                self.left(job)
                or any(one['job'] is job for one in there)
                or any(one['state'] != 'done' for one in first)
            ):
                continue
            job['over'] = True
            self.begins(job)
            self.say('job.aborted' if job['aborting'] else 'job.completed', (job['id'],))

    def abort_job(self, job: Row) -> None:
        if job['aborting']:
            return
        job['aborting'] = True
        self.say('job.aborting', (job['id'],))
        for item in job.get('items', []):
            if not self.empty(item):
                self.reject(item)
        for key, work in list(self.work.items()):
            if key[0] == job['id'] and work['state'] == 'running':
                self.cancel(work, 'abort_job')

    def reject(self, item: Row) -> None:
        if not item['rejected']:
            item['rejected'] = True
            self.say('item.rejected', (item['job']['id'],), item=item['id'])

    # --- initialization ---------------------------------------------------------------------

    def initialization(self) -> None:
        for job in self.live():
            for task in job['plan']['first']:
                self.prepare(job, task, (job['id'], None, None, task['id']))

    def prepare(self, job: Row, task: Row, key: tuple[Any, ...]) -> None:
        work = self.of(key)
        if work['state'] in ('new', 'waiting') and not self.stopped(None):
            done_before = task['once'] and self.once_key(job, task) in self.once
            if job['aborting'] or done_before:
                self.say('task.skipped', key)
                work['state'] = 'done'
        if work['state'] == 'new':
            before = [self.of((*key[:3], upstream))['state'] for upstream in task['after']]
            earlier = all(self.done_with_earlier(n, job) for n in self.places(task))
            if not earlier or set(before) - {'done'} or self.state != 'Execute' or self.holds:
                return
        self.visit(key, task, job, None)

    def once_key(self, job: Row, task: Row) -> str:
        args = {name: value_of(value, job, None) for name, value in task['args'].items()}
        return repr((task['action'], task['task'], sorted(args.items())))

    def places(self, task: Row) -> Sequence[int]:
        return self.devices[task['action']]['places'] or range(1, self.size + 1)

    def prepared(self, number: int, job: Row) -> bool:
        """Tell whether a section may begin a job's first cycle (5.2)."""
        plan = job['plan']
        rows = {task['id']: task for task in plan['first']}
        for task in plan['first']:
            if self.of((job['id'], None, None, task['id']))['state'] == 'done':
                continue
            if number in self.places(task):
                return False
            behind = max(self.waits_for(task, rows)) > min(self.places(task))
            if number == plan['source'] and behind:
                return False
        return True

    def waits_for(self, task: Row, rows: Row) -> set[int]:
        found = set(self.places(task))
        for upstream in task['after']:
            found |= self.waits_for(rows[upstream], rows)
        return found

    # --- sections ---------------------------------------------------------------------------

    def section(self, number: int) -> None:
        cycle = self.cycles[number]
        if cycle is None:
            self.begin(number)
            return
        job, item = cycle['job'], cycle['item']
        steps = job['plan']['lists'][number]
        last = max([n for n, step in enumerate(steps) if needs_belt(step)], default=-1)
        while True:
            early = job['plan']['early'][number] and cycle['step'] > last
            if (early or cycle['step'] == len(steps)) and number not in item['turned']:
                self.turn_over(number, job, item)
            if cycle['step'] == len(steps):
                break
            rests = not self.moving and self.beat >= cycle['beat']
            if not self.step(number, cycle, steps[cycle['step']], rests):
                return
            cycle['step'] += 1
        item['handled'].add(number)
        self.cycles[number] = None
        self.say('cycle.completed', (job['id'], number, item['id']))

    def turn_over(self, number: int, job: Row, item: Row) -> None:
        item['turned'].add(number)
        self.say('turn.completed', (job['id'], number, item['id']))

    def step(self, number: int, cycle: Row, step: list[list[Row]], rests: bool) -> bool:
        ended = True
        for member in step:
            for task in member:
                key = (cycle['job']['id'], number, cycle['item']['id'], task['id'])
                if self.of(key)['state'] == 'new' and needs_belt(step) and not rests:
                    return False
                if not self.visit(key, task, cycle['job'], cycle['item']):
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
            job['begun'] += 1
            item = {'job': job, 'id': f'{job["id"]}/{job["begun"]}', 'number': job['begun']}
            item |= {'rejected': False, 'standing': False, 'missing': False, 'gone': False}
            item |= {'results': {}, 'handled': set(), 'turned': set()}
            job.setdefault('items', []).append(item)
        self.begins(job)
        self.last_beat[number] = beat
        self.cycles[number] = {'job': job, 'item': item, 'beat': beat, 'step': 0}
        self.say('cycle.started', (job['id'], number, item['id']), beat=beat)

    def next_of(self, number: int) -> tuple[Row | None, Row | None, int]:
        """Return job, item (None at the source) and beat of a section's next cycle."""
        place = number - 1 if self.moving else number
        item = self.slots[place] if place else None
        to_come = self.beat + 1 if self.moving else self.beat
        plan: Row = item['job']['plan'] if item else {'lists': (), 'source': 0}
        owed = item and number in plan['lists'] and number not in item['handled']
        if item and owed and number != plan['source']:
            return item['job'], item, to_come
        job = self.source_job(number)
        if job is None:
            return None, None, 0
        taken = not self.moving and self.slots[number] is not None
        if taken or self.last_beat[number] >= to_come:
            to_come += 1
        return (job, None, to_come) if to_come <= self.beat + 1 else (None, None, 0)

    def source_job(self, number: int) -> Row | None:
        job = next((job for job in self.live() if self.left(job)), None)
        if job is None or job['plan']['source'] != number:
            return None
        return job if self.done_with_earlier(number, job) else None

    # --- tasks ------------------------------------------------------------------------------

    def of(self, key: tuple[Any, ...]) -> Row:
        return self.work.setdefault(
            key, {'key': key, 'state': 'new', 'attempt': 0, 'after': 0.0, 'cause': None}
        )

    def empty(self, item: Row) -> bool:
        return bool(item['missing'] or item['gone'])

    def visit(self, key: tuple[Any, ...], task: Row, job: Any, item: Row | None) -> bool:
        """Let a task go on as far as it can; tell whether it ended."""
        work = self.of(key)
        if work['state'] == 'failed':
            self.decide(work, task, job, item)
            return False
        if work['state'] in ('new', 'waiting') and not self.stopped(key[1]):
            return self.try_start(work, task, job, item)
        return bool(work['state'] == 'done')

    def stopped(self, number: int | None) -> bool:
        return self.paused or any(
            hold['key'][1] == number and hold['key'][0] for hold in self.holds.values()
        )

    def try_start(self, work: Row, task: Row, job: Row | None, item: Row | None) -> bool:
        missing = False
        if item is not None and job is not None:
            if work['state'] == 'new' and not self.flags_allow(task, job):
                return False
            try:
                skipped = self.passes(task, job, item)
                for value in () if skipped else task['args'].values():
                    value_of(value, job, item)
            except MissingResult:
                skipped, missing = False, True
            if skipped:
                self.say('task.skipped', work['key'])
                self.executed(work, task, job, item, done=False)
                return True
        names = [task['device'], *(f'zone {zone}' for zone in task['zones'])]
        if self.now < work['after'] or any(name in self.taken for name in names):
            return False
        if missing:
            work['attempt'] += 1
            self.fail(work, 'missing_result')
            self.decide(work, task, job, item)
            return False
        self.begins(job)
        self.send(work, task, names)
        return False

    def flags_allow(self, task: Row, job: Row) -> bool:
        for link in job['plan']['flags']:
            if link['upstream'] == task['id'] and self.flags[link['flag']] >= link['capacity']:
                return False
            if link['downstream'] == task['id'] and self.flags[link['flag']] == 0:
                return False
        return True

    def passes(self, task: Row, job: Row, item: Row) -> bool:
        """Tell whether a task is skipped (3.2, 6.4, 6.5)."""
        if self.empty(item) and item['gone'] != 'sink':
            return True
        state = 'rejected' if item['rejected'] else 'good'
        return task['runs_for'] not in (state, 'all') or not wanted(task, job, item)

    def executed(self, work: Row, task: Row, job: Row, item: Row | None, *, done: bool) -> None:
        """Change flags, quantity and item as a task that ended does (2.7, 3.2, 4.2)."""
        work['state'] = 'done'
        for side, event, change in (('upstream', 'raised', 1), ('downstream', 'lowered', -1)):
            for link in job['plan']['flags'] if item else ():
                if link[side] == task['id']:
                    self.flags[link['flag']] += change
                    count = self.flags[link['flag']]
                    self.say(f'flag.{event}', work['key'], flag=link['flag'], count=count)
        if item and task['qty_change'] == 1:
            item['standing'], item['missing'] = True, not done
            self.slots[work['key'][1]] = item
            self.say('item.placed' if done else 'item.missing', work['key'][:3])
        if item and task['qty_change'] == -1 and done and not self.empty(item):
            self.take_out(item, work['key'][1], 'rejected' if item['rejected'] else 'packed')
        elif (
            item
            and task['qty_change'] == -1
            and self.slots[work['key'][1]] is item
            and self.empty(item)
            and work['key'][1] == job['plan']['sink']
        ):
            self.slots[work['key'][1]] = None
            self.say('position.ended', work['key'][:3])

    def take_out(self, item: Row, number: int | None, how: str) -> None:
        at_sink = number == item['job']['plan']['sink'] and how != 'by_hand'
        item['gone'] = 'sink' if at_sink else 'early'
        if at_sink and number is not None:
            self.slots[number] = None
        self.say('item.removed', (item['job']['id'], number, item['id']), how=how)

    # --- goals ------------------------------------------------------------------------------

    def send(self, work: Row, task: Row, names: list[str]) -> None:
        work['state'], work['cause'], work['task'] = 'running', None, task
        work['attempt'] += 1
        self.work[work['key']] = self.work.pop(work['key'])
        for name in names:
            self.taken[name] = work['key']
        fields = {'name': task['task'], 'action': task['action'], 'component': task['device']}
        self.say('task.started', work['key'], attempt=work['attempt'], **fields)
        work['goal'] = {'work': work, 'task': task, 'attempt': work['attempt']}
        work['deaf'] = True
        self.unsent.append(work['goal'])

    def arrive(self, goal: Row) -> None:
        """Let the simulated controller do what it does with a goal (docs/formats.md)."""
        work, task = goal['work'], goal['task']
        name = task['device']
        self.at(self.now + task['timeout'], {'limit': 'timeout', **goal})
        if name in self.dead:
            self.at(self.now, {'end': 'goal_rejected', **goal})
            return
        self.counts[name] += 1
        self.counts[name, task['task']] += 1
        device = self.devices[task['action']]
        counts = self.counts[name], self.counts[name, task['task']]
        kind, extra = fault_of(device, task['task'], *counts)
        work['deaf'] = kind in ('ignore_cancel', 'mute')
        if kind in ('reject', 'mute'):
            reason = 'goal_rejected' if kind == 'reject' else 'server_lost'
            wait_s = 0.0 if kind == 'reject' else CHECK_S * CHECKS_OF_A_REQUEST
            self.at(self.now + wait_s, {'end': reason, **goal})
            return
        if work['cause'] and not work['deaf']:
            self.at(self.now, {'end': 'canceled', **goal})
        nominal = device.get('durations', {}).get(task['task'], device.get('duration', 1.0))
        self.counts[name, 'accepted'] += 1
        drawn = self.duration(name, self.counts[name, 'accepted'])
        seconds = nominal if drawn is None else drawn
        ends = {'abort': 'aborted', 'cancel': 'canceled', 'false': 'task_result_false'}
        if kind == 'ignore_cancel':
            self.dead.add(name)
        elif kind == 'die':
            checks = -(-(seconds / 2 + (extra or 0.0)) // CHECK_S)
            self.at(
                self.now + CHECK_S * max(checks, 1), {'end': 'server_lost', 'rank': 'late', **goal}
            )
        elif kind != 'hang':
            late_s = extra or 0.0 if kind == 'late' else 0.0
            self.at(self.now + seconds + late_s, {'end': ends.get(kind), **goal})

    def cancel(self, work: Row, cause: str) -> None:
        if work['cause'] is None:
            work['cause'] = cause
            self.say('task.cancel_requested', work['key'], cause=cause)
            self.at(self.now + GRACE_S, {'limit': 'grace', **work['goal']})
            if not work['deaf']:
                self.at(self.now, {'end': 'canceled', 'rank': 'canceled by us', **work['goal']})

    def limit_reached(self, limit: Row) -> None:
        work = limit['work']
        if work['state'] == 'running' and work['attempt'] == limit['attempt']:
            if limit['limit'] == 'timeout':
                self.cancel(work, 'timeout')
            else:
                self.fail(work, 'in_doubt')

    def goal_ended(self, goal: Row) -> None:
        if 'wake' in goal:
            return
        work, reason = goal['work'], goal['end']
        if work['state'] != 'running' or work['attempt'] != goal['attempt']:
            return
        if reason is not None:
            if reason == 'canceled' and work['cause'] == 'timeout':
                reason = 'timeout'
            self.fail(work, reason)
        else:
            self.succeed(work, goal['task'])

    def free(self, work: Row) -> None:
        self.taken = {name: key for name, key in self.taken.items() if key != work['key']}

    def succeed(self, work: Row, task: Row) -> None:
        self.free(work)
        device = self.devices[task['action']]
        results = {'item_present': True, 'measurement': 0.0}
        results |= device.get('results', {}).get(task['task'], {})
        if task['device'] == 'conveyor':
            results = {}
        fields = {'results': results} if results else {}
        self.say('task.succeeded', work['key'], attempt=work['attempt'], **fields)
        self.effects(work, task, results)

    def effects(self, work: Row, task: Row, results: Row) -> None:
        if work['key'] == INDEX:
            self.moved()
            return
        job = self.job_of(work['key'])
        item = self.item_of(work['key'])
        if item is None:
            self.once.add(self.once_key(job, task))
        elif results:
            item['results'][task['id']] = results
        self.executed(work, task, job, item, done=True)

    def job_of(self, key: tuple[Any, ...]) -> Row:
        return next(job for job in self.jobs if job['id'] == key[0])

    def item_of(self, key: tuple[Any, ...]) -> Row | None:
        items = self.job_of(key).get('items', []) if key[0] else []
        return next((item for item in items if item['id'] == key[2]), None)

    def fail(self, work: Row, reason: str) -> None:
        work['state'], work['reason'] = 'failed', reason
        if reason not in ('in_doubt', 'server_lost'):
            self.free(work)
        self.say('task.failed', work['key'], attempt=work['attempt'], reason=reason)

    # --- failures and operators -------------------------------------------------------------

    def decide(self, work: Row, task: Row, job: Row | None, item: Row | None) -> None:
        reason, lost = work['reason'], work['reason'] == 'server_lost' and not task['repeatable']
        if reason == 'in_doubt' or lost:
            self.hold(work, task, item)
        elif work['cause'] == 'abort_job':
            self.go_on(work, task, job, item, 'abort_job')
        elif work['attempt'] <= task['retries'] and reason != 'missing_result':
            self.retry(work, task['retry_delay'])
        elif task['policy'] == 'hold':
            self.hold(work, task, item)
        else:
            self.go_on(work, task, job, item, task['policy'])

    def retry(self, work: Row, delay_s: float) -> None:
        self.free(work)
        work['state'], work['after'] = 'waiting', round(self.now + delay_s, 6)
        self.at(work['after'], {'wake': True})
        fields = {'attempt': work['attempt'] + 1, 'not_before': work['after']}
        self.say('task.retrying', work['key'], **fields)

    def go_on(self, work: Row, task: Row, job: Row | None, item: Row | None, policy: str) -> None:
        if policy == 'abort_job':
            self.abort(work, job)
        if policy == 'reject' and item:
            self.reject(item)
        if work['key'] == INDEX:
            self.hold(work, task, item)
            return
        self.free(work)
        self.say('task.continued', work['key'], policy=policy)
        assert job is not None
        self.executed(work, task, job, item, done=False)

    def abort(self, work: Row, job: Row | None) -> None:
        for one in self.live():
            if one is job or (
                job is None and any(i and i['job'] is one for i in self.slots.values())
            ):
                self.abort_job(one)

    def hold(self, work: Row, task: Row, item: Row | None) -> None:
        work['state'] = 'held'
        self.hold_count += 1
        answers = ['retry', 'mark_done', 'skip', 'reject', 'abort_job']
        if task['qty_change'] == -1 or work['key'] == INDEX:
            answers.remove('skip')
        if item is None:
            answers.remove('reject')
        row = {'key': work['key'], 'work': work, 'task': task, 'answers': answers}
        self.holds[str(self.hold_count)] = row
        fields = {'hold': str(self.hold_count), 'reason': work['reason'], 'answers': answers[:]}
        self.say('hold.raised', work['key'], **fields)

    def answer(self, hold_id: str, answer: str) -> None:
        hold = self.holds.pop(hold_id)
        work, task, key = hold['work'], hold['task'], hold['key']
        job = self.job_of(key) if key[0] else None
        item = self.item_of(key)
        self.say('operator.decided', (), answer=answer, hold=hold_id)
        if key == INDEX and answer == 'abort_job':
            self.holds[hold_id] = hold
            self.abort(work, None)
            self.settle()
            return
        self.say('hold.released', (), hold=hold_id)
        if answer == 'retry':
            self.retry(work, 0.0)
        elif answer == 'mark_done':
            self.free(work)
            self.say('task.marked_done', key)
            self.effects(work, task, {})
        elif answer == 'skip':
            self.free(work)
            self.say('task.skipped', key)
            assert job is not None
            self.executed(work, task, job, item, done=False)
        else:
            self.go_on(work, task, job, item, answer)
        self.settle()
        return

    def remove(self, item_id: str) -> bool:
        """Take an item off the belt by hand (7.1)."""
        for number, item in self.slots.items():
            if item and item['id'] == item_id and not self.empty(item):
                self.say('operator.decided', (), item=item_id, answer='remove_item')
                self.take_out(item, number, 'by_hand')
                for hold_id, hold in list(self.holds.items()):
                    if hold.get('overrun') == item_id:
                        del self.holds[hold_id]
                        self.say('hold.released', (), hold=hold_id)
                self.settle()
                return True
        return False

    def pause(self, paused: bool) -> None:
        self.paused = paused
        if paused:
            self.hold_count += 1
            self.say('operator.decided', (), answer='pause')
            fields = {'hold': str(self.hold_count), 'reason': 'paused', 'answers': ['resume']}
            self.holds[str(self.hold_count)] = {'key': INDEX, 'answers': [], 'pause': True}
            self.say('hold.raised', (), **fields)
        else:
            self.say('operator.decided', (), answer='resume')
            for hold_id in [id_ for id_, hold in self.holds.items() if hold.get('pause')]:
                del self.holds[hold_id]
                self.say('hold.released', (), hold=hold_id)
        self.settle()

    # --- the belt ---------------------------------------------------------------------------

    def belt(self) -> None:
        if self.moving:
            self.visit(INDEX, self.index_row(), None, None)
            return
        if any(self.pending(n) for n in self.slots):
            return
        last = self.slots[self.size]
        if last is not None and not self.empty(last):
            self.overrun(last)
            return
        if self.state != 'Execute' or self.holds:
            return
        if not any(self.slots.values()):
            if self.source_goes_on():
                self.beat += 1
                self.say('beat.started', (), beat=self.beat)
            return
        self.moving = True
        self.say('belt.index_started', (), beat=self.beat)
        self.work.pop(INDEX, None)
        self.visit(INDEX, self.index_row(), None, None)

    def index_row(self) -> Row:
        device = self.devices[self.belt_row['action']]
        keys = ('task', 'action', 'retries', 'on_failure')
        given = {name: self.belt_row[name] for name in keys if name in self.belt_row}
        return task_row(given, 'index', device)

    def source_goes_on(self) -> bool:
        """Tell whether the source has a cycle for the next beat, begun ahead or to come."""
        if any(cycle and cycle['beat'] > self.beat for cycle in self.cycles.values()):
            return True
        return any((job := self.source_job(n)) and self.prepared(n, job) for n in self.slots)

    def pending(self, number: int) -> bool:
        item, cycle = self.slots[number], self.cycles[number]
        if item and number in item['job']['plan']['lists'] and number not in item['turned']:
            return True
        if cycle and cycle['beat'] <= self.beat and number not in cycle['item']['turned']:
            return True
        job = self.source_job(number)
        if job is None or item or self.last_beat[number] >= self.beat:
            return False
        return job['begun'] > 0 or self.prepared(number, job)

    def overrun(self, item: Row) -> None:
        if any(hold.get('overrun') == item['id'] for hold in self.holds.values()):
            return
        self.hold_count += 1
        key = (item['job']['id'], self.size, item['id'], None)
        row = {'key': key, 'overrun': item['id'], 'answers': ['remove_item']}
        self.holds[str(self.hold_count)] = row
        fields = {'hold': str(self.hold_count), 'reason': 'overrun', 'answers': ['remove_item']}
        self.say('hold.raised', key, **fields)

    def moved(self) -> None:
        self.work[INDEX]['state'] = 'done'
        for number in range(self.size, 0, -1):
            item = self.slots[number]
            self.slots[number] = None
            if item and number == self.size:
                self.say('position.ended', (item['job']['id'], number, item['id']))
            elif item:
                self.slots[number + 1] = item
                self.say('item.moved', (item['job']['id'], number + 1, item['id']))
        self.moving = False
        self.beat += 1
        self.say('belt.indexed', (), beat=self.beat)

    # --- the cell's state -------------------------------------------------------------------

    def cell_state(self, seen: int) -> None:
        """Make one transition, if one is due (7.1, 7.2)."""
        passing = {
            'Resetting': 'Idle',
            'Starting': 'Execute',
            'Unholding': 'Execute',
            'Completing': 'Complete',
        }
        if self.live():
            passing |= {'Stopped': 'Resetting', 'Complete': 'Resetting', 'Idle': 'Starting'}
        else:
            passing['Execute'] = 'Completing'
        if self.holds:
            passing |= dict.fromkeys(('Execute', 'Starting', 'Unholding'), 'Holding')
            if seen == len(self.records) and not any(map(self.goes_on, self.work.values())):
                passing['Holding'] = 'Held'
        else:
            passing |= {'Holding': 'Held', 'Held': 'Unholding'}
        if self.state in passing:
            state, self.state = self.state, passing[self.state]
            self.say('cell.state_changed', (), state=self.state, previous=state)

    def goes_on(self, work: Row) -> bool:
        waits = work['state'] == 'waiting' and work['after'] > self.now
        return bool(waits or work['state'] == 'running')
