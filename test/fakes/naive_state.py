"""The state of the naive cell, and what an operator commands it to (7.2)."""

from __future__ import annotations

from abc import abstractmethod

from fakes.naive_run import NaiveRun, Task

WORKS = ('Execute', 'Holding', 'Held', 'Unholding', 'Stopping')
"""States in which cycles in hand go on (7.2)."""
ABORTED = ('Aborting', 'Aborted')
GOES_ON = {'Aborted': ['clear'], 'Stopped': ['reset'], 'Complete': ['reset'], 'Idle': ['start']}
"""The way from each state that waits for an operator to work."""
LEADS_TO = {
    'abort': 'Aborting',
    'clear': 'Clearing',
    'stop': 'Stopping',
    'reset': 'Resetting',
    'start': 'Starting',
}


class NaiveState(NaiveRun):
    """A cell that is stopped, works, or is held."""

    def may_begin(self) -> bool:
        return self.state == 'Execute' and not self.holds

    def stopped(self, number: int | None) -> bool:
        """Tell whether a pause, a hold or the cell keeps a section from starting anything (7)."""
        if self.state not in WORKS:
            return True
        places = [hold.where['section'] for hold in self.holds if 'section' in hold.where]
        return number in places or any(hold.reason == 'paused' for hold in self.holds)

    def commands(self) -> list[str]:
        """Return the commands to the cell that are possible now (7.2)."""
        possible = GOES_ON.get(self.state, [])
        if any(hold.task is self.move for hold in self.holds):
            possible = [command for command in possible if command != 'clear']
        stop = [] if self.state in ('Stopping', 'Stopped', *ABORTED) else ['stop']
        return [*possible, *stop, *([] if self.state in ABORTED else ['abort'])]

    def command(self, what: str) -> None:
        """Let an operator command the cell; no order undoes what stopped it (7.2)."""
        self.say('operator.decided', {}, answer=what)
        self.stopped_by_hand = what != 'start' and (what != 'reset' or self.stopped_by_hand)
        self.enter(LEADS_TO[what])
        if what == 'abort':
            for task in [candidate for candidate in self.started if candidate.state == 'running']:
                self.cancel(task, 'abort')

    def service(self, component: str) -> None:
        """Let an operator take a component out of service, or bring it back (7.5)."""
        is_out = component not in self.out
        what, concerned = ('out_of' if is_out else 'in') + '_service', {'component': component}
        self.say('operator.decided', {}, answer=what, **concerned)
        jobs = [
            entry.id
            for entry in self.jobs
            if component in entry.needs and not self.has_begun(entry)
        ]
        self.say(f'component.{what}', {}, **concerned, jobs=jobs if is_out and jobs else None)
        self.out = [entry for entry in (*self.out, component) if is_out or entry != component]
        if is_out:
            self.forget_setups(component)
        self.had_work |= bool(self.able())

    def release(self, script: str) -> None:
        """Let an engineer release a script (6.10)."""
        self.say('operator.decided', {}, answer='release_script')
        self.say('script.released', {})
        self.generated.discard(script)
        self.had_work |= bool(self.able())

    @abstractmethod
    def forget_setups(self, *names: str) -> None: ...

    @abstractmethod
    def cancel(self, task: Task, cause: str) -> None: ...

    def enter(self, state: str) -> None:
        """Be in another state; what was done once is forgotten where the cell stands (5.1)."""
        previous, self.state = self.state, state
        self.say('cell.state_changed', {}, state=state, previous=previous)
        if state == 'Starting':
            self.had_work = bool(self.able())
        if state in ('Stopped', 'Aborted'):
            self.done.clear()
            for task in [t for j in self.jobs if not j.items for t in j.first.values()]:
                if task.state == 'done' and not task.attempt:
                    task.state = 'new'
            self.forget_setups()

    def cell_state(self, *, still: bool) -> None:
        """Make one transition, if one is due."""
        working = 'Holding' if self.holds else 'Execute'
        due = {'Starting': working, 'Unholding': working}
        due |= {'Resetting': 'Idle', 'Completing': 'Complete', 'Clearing': 'Stopped'}
        if self.able() and not (self.stopped_by_hand or self.stop_after):
            due |= {'Stopped': 'Resetting', 'Complete': 'Resetting', 'Idle': 'Starting'}
        if self.had_work and not self.able() and not self.stop_after:
            due['Execute'] = 'Completing'
        running = any(task.state == 'running' for task in self.started)
        later = any(t.state == 'waiting' and t.not_before > self.now for t in self.started)
        if still and not running and not later:
            due |= {'Holding': 'Held', 'Stopping': 'Stopped', 'Aborting': 'Aborted'}
        if self.holds:
            due['Execute'] = 'Holding'
        else:
            due |= {'Holding': 'Held', 'Held': 'Unholding'}
        stands = self.state in ('Execute', *GOES_ON)
        if stands and still and not (running or later) and self.ends_empty():
            self.say('queue.stop_reached', {}, after=self.stop_after)
            self.stopped_by_hand, self.stop_after = True, ''
            due['Execute'] = 'Stopping'
        if self.state in due:
            self.enter(due[self.state])

    @abstractmethod
    def ends_empty(self) -> bool: ...
