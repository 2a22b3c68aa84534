"""The state of the naive cell, and what an operator commands it to (7.2)."""

from __future__ import annotations

from fakes.naive_run import NaiveRun

WORKS = ('Execute', 'Holding', 'Held', 'Unholding', 'Stopping')
"""States in which cycles in hand go on (7.2)."""


class NaiveState(NaiveRun):
    """A cell that is stopped, works, or is held."""

    def may_begin(self) -> bool:
        return self.state == 'Execute' and not self.holds

    def stopped(self, number: int | None) -> bool:
        """Tell whether a pause, a hold or the cell keeps a section from starting anything (7)."""
        if self.state not in WORKS:
            return True
        places = [hold.where['section'] for hold in self.holds if hold.where.get('job')]
        return number in places or any(hold.reason == 'paused' for hold in self.holds)

    def commands(self) -> list[str]:
        """Return the commands to the cell that are possible now (7.2)."""
        given = {'Stopped': ['reset'], 'Complete': ['reset'], 'Idle': ['start']}
        stop = [] if self.state in ('Stopping', 'Stopped') else ['stop']
        return given.get(self.state, []) + stop

    def command(self, what: str) -> None:
        """Let an operator stop the cell, or reset and start it; no order undoes a stop (7.2)."""
        self.say('operator.decided', {}, answer=what)
        self.stopped_by_hand = what == 'stop' or (self.stopped_by_hand and what != 'start')
        self.enter({'stop': 'Stopping', 'reset': 'Resetting', 'start': 'Starting'}[what])

    def enter(self, state: str) -> None:
        """Be in another state; in Stopped, what was done once is judged again (5.1)."""
        previous, self.state = self.state, state
        self.say('cell.state_changed', {}, state=state, previous=previous)
        if state == 'Starting':
            self.had_work = bool(self.jobs)
        if state == 'Stopped':
            self.done.clear()
            for task in [t for j in self.jobs if not j.items for t in j.first.values()]:
                if task.state == 'done' and not task.attempt:
                    task.state = 'new'

    def cell_state(self, *, still: bool) -> None:
        """Make one transition, if one is due."""
        working = 'Holding' if self.holds else 'Execute'
        due = {'Starting': working, 'Unholding': working}
        due |= {'Resetting': 'Idle', 'Completing': 'Complete'}
        if self.jobs and not self.stopped_by_hand:
            due |= {'Stopped': 'Resetting', 'Complete': 'Resetting', 'Idle': 'Starting'}
        if self.had_work and not self.jobs:
            due['Execute'] = 'Completing'
        running = any(task.state == 'running' for task in self.started)
        later = any(t.state == 'waiting' and t.not_before > self.now for t in self.started)
        if still and not running and not later:
            due |= {'Holding': 'Held', 'Stopping': 'Stopped'}
        if self.holds:
            due['Execute'] = 'Holding'
        else:
            due |= {'Holding': 'Held', 'Held': 'Unholding'}
        if self.state in due:
            self.enter(due[self.state])
