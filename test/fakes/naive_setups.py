"""What the naive cell knows of setups, and what follows from that (5.3)."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator

from fakes.naive_plan import change_of
from fakes.naive_run import LAST, Job, Task
from fakes.naive_state import NaiveState

TOLD_S = 5.0


class NaiveSetups(NaiveState):
    """A cell whose components have setups."""

    def is_change_needless(self, task: Task) -> bool:
        """Tell whether an implied change is skipped (5.3.3, 5.3.4)."""
        if 'late' not in task.given:
            return False
        setup, value = change_of(task.device, task.given) or ('', '')
        is_set = self.set_up(task, setup) == value
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
        there = [entry for entry in given if entry['action'] == task.given['action']]
        changed = [change_of(task.device, entry) for entry in there]
        source = self.done_with_earlier(task.job.plan.source, task.job)
        return source and setup[0] not in [entry[0] for entry in changed if entry]

    def lacking(self, task: Task) -> Iterator[Task]:
        """Yield the implied changes to what a task asks for and its component is not (5.3.5)."""
        for setup, value in task.given.get('setup', {}).items():
            if self.set_up(task, setup) != value:
                yield task.job.first[f'{task.device.name}.{setup}.{value}']

    def set_up(self, task: Task, setup: str) -> str | None:
        """Return what a setup of a component is, as far as it is known (5.3.1, 5.3.9)."""
        which = task.device.name, setup
        return self.topics.get(which) if is_read(task, setup) else self.setups.get(which)

    def is_untold(self, task: Task) -> bool:
        """Tell whether a task waits for a topic to tell its setup (5.3.9)."""
        asked = task.given.get('setup', {}).items()
        if all(self.set_up(task, name) == value for name, value in asked if is_read(task, name)):
            return False
        if task.asked != (task.attempt, task.round):
            task.asked, task.told_by = (task.attempt, task.round), round(self.now + TOLD_S, 6)
            self.at(TOLD_S, task, 'told', LAST)
        return self.now < task.told_by

    def note_told(self, component: str, setup: str, value: str) -> None:
        """Note what a topic tells; one told value may end in another (5.3.9)."""
        which, before = (component, setup), self.line_knows.get((component, setup), (value, True))
        self.topics[which] = value
        if before[0] != value and not before[1]:
            return  # the topic has not told the change yet
        self.line_knows[which] = value, True
        for task in [t for job in self.jobs for t in job.first.values() if 'late' in t.given]:
            changed = change_of(task.device, task.given)
            is_other = task.device.name == component and changed not in (None, (setup, value))
            if before[0] != value and is_other:
                self.evaluate_again(task)

    def evaluate_again(self, task: Task) -> None:
        """Let a change be evaluated again, if the sections have not begun its job (5.3.7)."""
        places = task.device.places
        begun = [self.said('cycle.started', item.at(n)) for item in task.job.items for n in places]
        if task.state == 'done' and not any(begun):
            task.state, task.attempt, task.not_before = 'new', 0, 0.0

    def is_changing(self, task: Task) -> bool:
        return any(change.state not in ('new', 'done') for change in self.lacking(task))

    def note_change(self, task: Task, *, done: bool) -> None:
        """Note that a change has begun, or was done (5.3.1)."""
        changed = change_of(task.device, task.given)
        if not changed:
            return
        which, value = (task.device.name, changed[0]), changed[1]
        if is_read(task, changed[0]):
            self.line_knows.pop(which, None)
            if done:
                self.line_knows[which] = value, self.topics.get(which) == value
            return
        self.setups.pop(which, None)
        if done:
            self.setups[which] = value

    def forget_setups(self, *names: str) -> None:
        """Know nothing any more, of some components or of all (5.3.1, 5.3.7)."""
        lost = {name for name, _ in self.setups if name in names or not names}
        self.setups = {key: v for key, v in self.setups.items() if key[0] not in lost}
        for task in [task for job in self.jobs for task in job.first.values()]:
            if 'late' in task.given and task.device.name in lost:
                self.evaluate_again(task)

    @abstractmethod
    def before(self, job: Job) -> list[Job]: ...

    @abstractmethod
    def done_with(self, number: int, job: Job) -> bool: ...

    @abstractmethod
    def done_with_earlier(self, number: int, job: Job) -> bool: ...


def is_read(task: Task, setup: str) -> bool:
    """Tell whether the state topic of a component tells one of its setups (5.3.9)."""
    return 'reads' in task.device.given.get('changes', {}).get(setup, {})


def read_change(task: Task) -> tuple[str, str] | None:
    """Return the setup and the value that a task changes, if a topic tells it."""
    changed = change_of(task.device, task.given)
    return changed if changed and is_read(task, changed[0]) else None
