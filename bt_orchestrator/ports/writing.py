"""The outputs of the engine: to the disk, and to its followers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from bt_orchestrator.model.events import Event

_Result = TypeVar('_Result')
_Result_co = TypeVar('_Result_co', covariant=True)


class Writing(Protocol[_Result_co]):
    """A write in progress."""

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Tell whether it has ended, successfully or not; wait at most `within_s` for that."""

    def lasts(self, seconds: float) -> bool:
        """Wait so long at most; tell whether it still goes on. No thread is woken for this."""

    def result(self) -> _Result_co:
        """Return its result once it has ended, or raise its error."""


class Writer(Protocol):
    """Carries out disk writes one after another, in order; callers need not wait."""

    def begin(self, write: Callable[[], _Result]) -> Writing[_Result]:
        """Begin a write.

        A caller that saw `has_ended` return False is woken when it has ended.

        :param write: uses the journal, and nothing that changes meanwhile
        """


class EventSink(Protocol):
    """An output of the event stream; one that fails never stops the cell."""

    def publish(self, events: Sequence[Event]) -> None:
        """Publish durable events, oldest first."""
