"""The books of a running cell, made in a process of low priority that reads the journal.

It takes seconds for a day's events: neither the tick thread's interpreter nor the writer has time
for that. The process ends with each piece of work; a day needs it once or twice.
"""

from __future__ import annotations

import logging
import os
import threading
from pathlib import Path

from bt_orchestrator.base.child_process import (
    FAREWELL_S,
    ChildFailed,
    ChildProcess,
    be_modest,
    serve,
)
from bt_orchestrator.engine.runtime.writers import Writing
from bt_orchestrator.model.books import Books
from bt_orchestrator.model.keeping.journal_place import JournalPlace, journal_place

log = logging.getLogger(__name__)

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""

WITHIN_S = 600.0
"""Longest time for an answer, on a busy machine."""

_MADE, _FAILED = b'+', b'-'


class BooksProcess:
    """Asks the process, from a thread that only waits. Implements `ports.Bookkeeping`."""

    def __init__(self, journal: JournalPlace) -> None:
        """Prepare; nothing is started yet.

        :param journal: which this process writes
        """
        self._journal = journal.resolve() if isinstance(journal, Path) else journal
        self._process: ChildProcess | None = None
        self._thread: threading.Thread | None = None

    def begin(self) -> Writing[Books]:
        """Begin to make the next books."""
        process = ChildProcess(__name__, os.fsencode(self._journal))
        making = Writing(lambda: _ask(process), lambda: None)
        self._process = process
        self._thread = threading.Thread(target=making.run, name='books', daemon=True)
        self._thread.start()
        return making

    def close(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process.close()
        if self._thread is not None:
            self._thread.join(FAREWELL_S)


def _ask(process: ChildProcess) -> Books:
    """Return the answer of a process, which ends with it.

    :raises ChildFailed: there is none
    """
    try:
        answer = process.ask(b'', WITHIN_S)
    finally:
        process.close()
    if answer[:1] == _FAILED:
        raise ChildFailed(answer[1:].decode())
    return Books.from_bytes(answer[1:])


class _Answers:
    """The knowledge of the process: the file of the first question."""

    def __init__(self) -> None:
        self._journal: JournalPlace | None = None

    def __call__(self, question: bytes) -> bytes:
        if self._journal is None:
            self._journal = journal_place(os.fsdecode(question))
            return b''
        try:
            return _MADE + _next_books(self._journal).to_bytes()
        except Exception as error:  # noqa: BLE001 - told to the node, which goes on without
            return _FAILED + (str(error) or repr(error)).encode()


def _next_books(journal: JournalPlace) -> Books:
    from contextlib import closing

    from bt_orchestrator.cli.journal_file import open_records
    from bt_orchestrator.view.report.account.bookkeeper import next_books

    with closing(open_records(journal)) as records:
        return next_books(records, log.warning)


def main() -> None:
    """Make books until the node has ended."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
