"""Replies that may come later, and steps that wait for them, all in one thread.

`begin` runs a coroutine without an event loop: if an awaited reply is there it continues at once,
so the usual case is plain calls in order. Otherwise it continues in the call that gives the reply;
an rclpy executor would poll it in each of its turns.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Generator
from typing import Any, Generic, TypeVar

_T = TypeVar('_T')

Steps = Coroutine['Reply[Any]', None, _T]
"""A coroutine that awaits only replies, and other such coroutines."""


class Reply(Generic[_T]):
    """A value that is given once, now or later."""

    def __init__(self) -> None:
        self._values: list[_T] = []
        self._calls: list[Callable[[_T], object]] = []

    @property
    def is_there(self) -> bool:
        """Tell whether it was given."""
        return bool(self._values)

    @property
    def value(self) -> _T:
        """The results of an answer."""
        assert self._values, 'the reply has not come yet'
        return self._values[0]

    def give(self, value: _T) -> None:
        """Give it to all that wait, in the order of their requests."""
        assert not self._values, 'a reply is given once'
        self._values.append(value)
        calls, self._calls = self._calls, []
        for call in calls:
            call(value)

    def then(self, call: Callable[[_T], object]) -> None:
        """Call a function with the value: now, or when it is given."""
        if self._values:
            call(self._values[0])
        else:
            self._calls.append(call)

    def __await__(self) -> Generator[Reply[Any], None, _T]:
        while not self._values:  # rclpy polls its coroutines
            yield self
        return self.value


def begin(steps: Steps[_T]) -> Reply[_T]:
    """Run steps until they await a reply that is not there, and continue when it comes.

    An exception is raised where they run: here, or in the call that gives a reply.

    :return: their result, once they have ended
    """
    ended: Reply[_T] = Reply()

    def go_on(_: object = None) -> None:
        try:
            awaited = steps.send(None)
        except StopIteration as end:
            ended.give(end.value)
        else:
            awaited.then(go_on)

    go_on()
    return ended
