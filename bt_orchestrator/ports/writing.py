"""The outputs of the engine: to the disk, to its followers, and to books."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.books import Books

_Result = TypeVar('_Result')
_Result_co = TypeVar('_Result_co', covariant=True)


class Writing(Protocol[_Result_co]):
    """A write in progress."""

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Tell whether it has ended, successfully or not; wait at most `within_s` for that."""

    def is_at_disk(self, within_s: float) -> bool:
        """Tell whether the disk alone works on it; wait at most `within_s` for that or its end.

        Asked once at most. No thread is woken for this.
        """

    def result(self) -> _Result_co:
        """Return its result once it has ended, or raise its error."""


class Worker(Protocol):
    """Reads or writes the journal, one call after another in order; callers need not wait."""

    def begin(self, write: Callable[[], _Result]) -> Writing[_Result]:
        """Begin to read or write.

        A caller that saw `has_ended` return False is woken when it has ended.

        :param write: uses the journal, and nothing that changes meanwhile
        """


class Writer(Worker, Protocol):
    """Carries out disk writes."""

    def reaches_disk(self) -> None:
        """Note that only the disk still works on the present write; called by that write."""


class EventSink(Protocol):
    """An output of the event stream; one that fails never stops the cell."""

    def publish(self, events: Sequence[Event]) -> None:
        """Publish durable events, oldest first."""


# Who knows which stops of the line a journal has.


class StopSearch(Protocol):
    """Looks for stops of the line in a journal, outside the tick thread."""

    async def has(self, seq: int) -> bool:
        """Tell whether a stop of the line began with an event. Only replies are awaited.

        :raises NotRead: says why it cannot be told
        """

    def close(self) -> None:
        """Stop working."""


# The maker of the books of a journal.


class Bookkeeping(Protocol):
    """Makes the account of a journal in slots of time, outside the tick thread."""

    def begin(self) -> Writing[Books]:
        """Begin to make the next books: from some events after those that are in books.

        Its result raises `ChildFailed` or `JournalUnusable`; then nothing was made.
        """

    def close(self) -> None:
        """Stop working."""
