"""Reading the blackboard, and what is done on it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any, NamedTuple

from py_trees.blackboard import Blackboard

_KEPT = 500
"""How many activities are kept for a stream that has not shown them yet."""

UNSET = '-'


def variables() -> list[str]:
    """Return every key that a client has registered."""
    return sorted(Blackboard.keys())


def values(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return variables with their values as text.

    :param names: keys, or KEY.FIELD; a key may lack its first slash
    """
    return [(name, _value(name)) for name in names]


def key_of(name: str) -> str:
    """Return the key that a variable or a field of it belongs to."""
    return str(Blackboard.absolute_name('/', name)).split('.')[0]


def _value(name: str) -> str:
    try:
        return str(Blackboard.get(name))
    except Exception:  # noqa: BLE001 - not set; or whatever a property or a str() of it raises
        return UNSET


class Activity(NamedTuple):
    """One thing that a client did; the values as text."""

    key: str
    client_name: str
    activity_type: str
    previous_value: str
    current_value: str


class ActivityLog:
    """The changes of the blackboard since some stream began to be interested.

    py_trees records it only meanwhile, as recording slows every access down.
    """

    def __init__(self) -> None:
        self.position = 0
        """Number of activities so far."""
        self._kept: list[Activity] = []
        self._recording = False

    def record(self, *, wanted: bool) -> None:
        """Begin or end to record."""
        if wanted and not self._recording:
            Blackboard.enable_activity_stream(maximum_size=_KEPT)
        elif self._recording and not wanted:
            Blackboard.disable_activity_stream()
            self._kept.clear()
        self._recording = wanted

    def collect(self) -> None:
        """Take in what was done since the last call."""
        stream = Blackboard.activity_stream
        if not self._recording or stream is None or not stream.data:
            return
        items, stream.data = stream.data, []
        self._kept += map(_activity, items)
        del self._kept[:-_KEPT]
        self.position += len(items)

    def since(self, position: int) -> list[Activity]:
        """Return the changes after a position, as far as they are kept."""
        missed = min(self.position - position, len(self._kept))
        return list(islice(self._kept, len(self._kept) - missed, None))


def _activity(item: Any) -> Activity:
    return Activity(
        str(item.key),
        str(item.client_name),
        str(item.activity_type),
        str(item.previous_value),
        str(item.current_value),
    )
