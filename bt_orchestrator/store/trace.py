"""A trace: the records of a run in a file, one JSON object per line (formats: events)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event


class UnusableTrace(OrchestratorError):
    """The file cannot be written."""


class TraceFile:
    """Writes every event as it comes. Implements `ports.EventSink`; a context that closes it."""

    def __init__(self, path: Path) -> None:
        """Create a file; an existing one is overwritten.

        :raises UnusableTrace: it cannot be written
        """
        self._path = path
        self._failure: OSError | None = None
        try:
            self._file = path.open('w', encoding='utf-8')
        except (OSError, ValueError) as error:
            raise self._unusable(error) from error

    def __enter__(self) -> TraceFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the file.

        :raises UnusableTrace: something could not be written and is missing
        """
        try:
            self._file.close()
        except OSError as failure:
            self._failure = self._failure or failure
        if self._failure is not None and error is None:
            raise self._unusable(self._failure) from self._failure

    def publish(self, events: Sequence[Event]) -> None:
        """Write the events; nothing more after a failure, so the file has no gap."""
        if self._failure is not None:
            return
        lines = [to_text(event) + '\n' for event in events]
        try:
            self._file.write(''.join(lines))
            self._file.flush()
        except OSError as failure:
            self._failure = failure

    def _unusable(self, error: OSError | ValueError) -> UnusableTrace:
        reason = getattr(error, 'strerror', None) or str(error)
        return UnusableTrace(f'cannot write the trace {self._path}: {reason}')
