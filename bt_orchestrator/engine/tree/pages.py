"""Paging of long lists: the tree's size is independent of a script's length.

Creating the behaviours of a task takes about 0.3 ms of the only thread, and each tick, viewer and
readiness check goes through all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Subject, is_done
from bt_orchestrator.engine.tree.ticking import InOrder, Ticked
from bt_orchestrator.model.script import Script, Task

MOST_WHOLE = 200
"""A script with no more tasks than this is in the tree completely, for viewers."""

PAGE = 40
"""Tasks of a page; a step is never split."""

_T = TypeVar('_T')


def is_long(script: Script) -> bool:
    """Tell whether the lists of a script are in pages."""
    return len(script.tasks) > MOST_WHOLE


def paged(parts: Sequence[_T], tasks_of: Callable[[_T], int]) -> Iterator[Sequence[_T]]:
    """Split a list of steps, or of the tasks of a track, into pages.

    :param tasks_of: returns the number of tasks of a part
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
    """A part of a long list, with behaviours only while the section works on it.

    When the last tasks have succeeded, all tasks before them have too, so they tell whether a page
    is passed: a tree compiled in the middle creates only what it needs.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        compiled: Callable[[], Sequence[Ticked]],
        last: Sequence[Subject],
    ) -> None:
        """Name a page after its tasks.

        :param compiled: creates its behaviours
        :param last: the tasks of its last step
        """
        super().__init__(f'{tasks[0].id} … {tasks[-1].id}', [])
        self._compiled = compiled
        self._last = last

    def run(self) -> Status:
        """Return SUCCESS if the page is passed, else create its behaviours and tick them."""
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
        """Set the status; INVALID: the section works elsewhere."""
        super().stop(new_status)
        if new_status is Status.INVALID:
            self._forget()

    def _forget(self) -> None:
        for child in self.children:
            for behaviour in child.iterate():
                detach(behaviour)
        self.remove_all_children()
        self.current_child = None


def detach(behaviour: Behaviour) -> None:
    """Close a behaviour's blackboard clients; py_trees would never release them."""
    for client in behaviour.blackboards:
        client.unregister()
    behaviour.blackboards.clear()
