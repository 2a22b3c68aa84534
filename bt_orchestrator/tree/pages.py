"""Long lists in pages, so that a script of any length costs the tree as much as a short one.

To make the behaviours of a task takes about 0.3 ms of the one thread, and each tick, watcher and
look for readiness goes through all that there are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.model.script import Script, Task
from bt_orchestrator.tree.subject import Subject, is_done
from bt_orchestrator.tree.ticking import InOrder, Ticked

MOST_WHOLE = 200
"""A script of so many tasks is in the tree as a whole, for whoever watches it."""

PAGE = 40
"""Tasks of a page; a step is never parted."""

_T = TypeVar('_T')


def is_long(script: Script) -> bool:
    """Tell whether the lists of a script are in pages."""
    return len(script.tasks) > MOST_WHOLE


def paged(parts: Sequence[_T], tasks_of: Callable[[_T], int]) -> Iterator[Sequence[_T]]:
    """Part a list of steps, or of the tasks of a track.

    :param tasks_of: counts the tasks of a part
    """
    page: list[_T] = []
    size = 0
    for part in parts:
        page.append(part)
        size += tasks_of(part)
        if size >= PAGE:
            yield page
            page, size = [], 0
    if page:
        yield page


class Page(InOrder):
    """A stretch of a long list, with behaviours only while the section is at it.

    What comes before a task has succeeded when it has, so the last tasks say whether a page is
    passed: a tree that is compiled in the middle makes nothing that it does not need.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        compiled: Callable[[], Sequence[Ticked]],
        last: Sequence[Subject],
    ) -> None:
        """Name a page after its tasks.

        :param compiled: makes its behaviours
        :param last: the tasks of its last step
        """
        super().__init__(f'{tasks[0].id} … {tasks[-1].id}', [])
        self._compiled = compiled
        self._last = last

    def run(self) -> Status:
        """Be passed, or have behaviours and tick them."""
        if not self.children:
            if all(map(is_done, self._last)):
                self.status = Status.SUCCESS
                return self.status
            for child in self._compiled():
                self.add_child(child)
            self.setup_with_descendants()
        if super().run() is Status.SUCCESS:
            self._forget()
        return self.status

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """Take a status; INVALID: the section is elsewhere."""
        super().stop(new_status)
        if new_status is Status.INVALID:
            self._forget()

    def _forget(self) -> None:
        for child in self.children:
            for behaviour in child.iterate():
                detach(behaviour)
        self.remove_all_children()


def detach(behaviour: Behaviour) -> None:
    """Close a behaviour's blackboard clients, which py_trees keeps for ever otherwise."""
    for client in behaviour.blackboards:
        client.unregister()
    behaviour.blackboards.clear()
