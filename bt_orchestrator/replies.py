"""Replies that may come later, and steps that wait for them, all in one thread.

`begin` runs a coroutine without an event loop: where it awaits a reply that is there it goes on at
once, so that the ordinary case is plain calls in their order. It goes on in the call that gives
the reply; an executor of rclpy would ask it again in each of its turns.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Generator
from typing import Any, Generic, TypeVar

_T = TypeVar('_T')

Steps = Coroutine['Reply[Any]', None, _T]
"""A coroutine that awaits nothing but replies, and others of its kind."""


class Reply(Generic[_T]):
    """A value that is there, or is given once, later."""

    def __init__(self) -> None:
        self._values: list[_T] = []
        self._calls: list[Callable[[_T], object]] = []

    @property
    def is_there(self) -> bool:
        """Tell whether it was given."""
        return bool(self._values)

    @property
    def value(self) -> _T:
        """What was given."""
        assert self._values, 'the reply has not come yet'
        return self._values[0]

    def give(self, value: _T) -> None:
        """Give it to all who wait, in the order in which they came."""
        assert not self._values, 'a reply is given once'
        self._values.append(value)
        calls, self._calls = self._calls, []
        for call in calls:
            call(value)

    def then(self, call: Callable[[_T], object]) -> None:
        """Call with it as soon as it is there: now, or when it is given."""
        if self._values:
            call(self._values[0])
        else:
            self._calls.append(call)

    def __await__(self) -> Generator[Reply[Any], None, _T]:
        while not self._values:  # rclpy asks its coroutines again and again
            yield self
        return self.value


def begin(steps: Steps[_T]) -> Reply[_T]:
    """Run steps as far as the replies are there that they await, and on as others come.

    What they raise is raised where they stand: here, or where a reply is given.

    :return: what they return, once they have ended
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
