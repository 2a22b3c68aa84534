"""What the naive cell knows of setups, and what follows from that (5.3)."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator

from fakes.naive_plan import change_of
from fakes.naive_run import Job, Task
from fakes.naive_state import NaiveState


class NaiveSetups(NaiveState):
    """A cell whose components have setups."""

    def is_change_needless(self, task: Task) -> bool:
        """Tell whether an implied change is skipped (5.3.3, 5.3.4)."""
        if 'late' not in task.given:
            return False
        setup, value = change_of(task.device, task.given) or ('', '')
        is_set = self.setups.get((task.device.name, setup)) == value
        return is_set or bool(task.given['late'] and task.state == 'new')

    def stays_set(self, task: Task) -> bool:
        """Tell whether nothing that comes first changes the setup any more (5.3.3)."""
        before = self.before(task.job)
        first = [t for job in [*before, task.job] for t in job.first.values() if t is not task]
        to_come = [t for t in first if t.state != 'done']
        given = [t.given for t in to_come if not (t.given.get('late') and t.state == 'new')]
        for job in before:
            for number in [n for n in job.plan.lists if not self.done_with(n, job)]:
                given += [t for step in job.plan.lists[number] for m in step for t in m]
        setup = change_of(task.device, task.given)
        assert setup
        there = [one for one in given if one['action'] == task.given['action']]
        changed = [change_of(task.device, one) for one in there]
        source = self.done_with_earlier(task.job.plan.source, task.job)
        return source and setup[0] not in [one[0] for one in changed if one]

    def lacking(self, task: Task) -> Iterator[Task]:
        """Yield the implied changes to what a task asks for and its component is not (5.3.5)."""
        for setup, value in task.given.get('setup', {}).items():
            if self.setups.get((task.device.name, setup)) != value:
                yield task.job.first[f'{task.device.name}.{setup}.{value}']

    def is_changing(self, task: Task) -> bool:
        return any(one.state not in ('new', 'done') for one in self.lacking(task))

    def note_change(self, task: Task, *, done: bool) -> None:
        """Note that a change has begun, or was done (5.3.1)."""
        changed = change_of(task.device, task.given)
        if changed:
            self.setups.pop((task.device.name, changed[0]), None)
            if done:
                self.setups[task.device.name, changed[0]] = changed[1]

    def forget_setups(self, *names: str) -> None:
        """Know nothing any more, of some components or of all (5.3.1, 5.3.7)."""
        lost = {name for name, _ in self.setups if name in names or not names}
        self.setups = {key: v for key, v in self.setups.items() if key[0] not in lost}
        for job in self.jobs:
            for task in job.first.values():
                begun = [
                    self.said('cycle.started', item.at(number))
                    for item in job.items
                    for number in task.device.places
                ]
                is_lost = 'late' in task.given and task.device.name in lost
                if is_lost and task.state == 'done' and not any(begun):
                    task.state, task.attempt, task.not_before = 'new', 0, 0.0

    @abstractmethod
    def before(self, job: Job) -> list[Job]: ...

    @abstractmethod
    def done_with(self, number: int, job: Job) -> bool: ...

    @abstractmethod
    def done_with_earlier(self, number: int, job: Job) -> bool: ...
