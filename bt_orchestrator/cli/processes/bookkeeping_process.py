"""The books of a running cell, made in a process of low priority that reads the journal.

It takes seconds for a day's events: neither the tick thread's interpreter nor the writer has time
for that. The process ends with each piece of work; a day needs it once or twice.
"""

from __future__ import annotations

import json
import logging
import os
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from bt_orchestrator.base.child_process import (
    FAREWELL_S,
    ChildFailed,
    ChildProcess,
    be_modest,
    serve,
)
from bt_orchestrator.base.errors import NotRead
from bt_orchestrator.base.replies import Reply
from bt_orchestrator.engine.runtime.writers import Writing
from bt_orchestrator.model.keeping.books import Books
from bt_orchestrator.model.keeping.journal_place import JournalPlace, journal_place

log = logging.getLogger(__name__)

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""

WITHIN_S = 600.0
"""Longest time for an answer, on a busy machine."""

MOST_ASKED = 5
"""Stops that are looked for at a time: each takes a process."""

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
    return Books.from_bytes(_answer(process, b''))


def _answer(process: ChildProcess, question: bytes) -> bytes:
    """Return the answer of a process, which ends with it.

    :raises ChildFailed: there is none
    """
    try:
        answer = process.ask(question, WITHIN_S)
    finally:
        process.close()
    if answer[:1] == _FAILED:
        raise ChildFailed(answer[1:].decode())
    return answer[1:]


class StopProcess:
    """Looks for stops in a process for each question. Implements `ports.StopSearch`."""

    def __init__(self, journal: JournalPlace, soon: Callable[[Callable[[], None]], None]) -> None:
        """Prepare; nothing is started yet.

        :param journal: which this process writes
        :param soon: lets the tick thread call something; called by another thread
        """
        self._journal = journal.resolve() if isinstance(journal, Path) else journal
        self._soon = soon
        self._asked: dict[threading.Thread, ChildProcess] = {}
        self._closed = False

    async def has(self, seq: int) -> bool:
        """Tell whether a stop of the line began with an event.

        :raises NotRead: says why it cannot be told
        """
        if len(self._asked) >= MOST_ASKED:
            raise NotRead(f'{MOST_ASKED} stops are looked for; classify this one again later')
        process, outcome = ChildProcess(__name__, os.fsencode(self._journal)), Reply[bool | str]()
        thread = threading.Thread(
            target=self._look, args=(process, seq, outcome), name='stops', daemon=True
        )
        self._asked[thread] = process
        thread.start()
        answer = await outcome
        del self._asked[thread]
        if isinstance(answer, str):
            raise NotRead(f'the journal cannot be searched for stops: {answer}')
        return answer

    def _look(self, process: ChildProcess, seq: int, outcome: Reply[bool | str]) -> None:
        answer: bool | str
        try:
            answer = bool(json.loads(_answer(process, str(seq).encode())))
        except Exception as error:  # noqa: BLE001 - told to the person who classifies
            answer = str(error) or repr(error)
        if not self._closed:
            self._soon(partial(outcome.give, answer))

    def close(self) -> None:
        """End the processes that look."""
        self._closed = True
        for thread, process in list(self._asked.items()):
            process.close()
            thread.join(FAREWELL_S)


class _Answers:
    """The knowledge of the process: the file of the first question."""

    def __init__(self) -> None:
        self._journal: JournalPlace | None = None

    def __call__(self, question: bytes) -> bytes:
        if self._journal is None:
            self._journal = journal_place(os.fsdecode(question))
            return b''
        try:
            if question:
                return _MADE + json.dumps(_has_stop(self._journal, int(question))).encode()
            return _MADE + _next_books(self._journal).to_bytes()
        except Exception as error:  # noqa: BLE001 - told to the node, which goes on without
            return _FAILED + (str(error) or repr(error)).encode()


def _next_books(journal: JournalPlace) -> Books:
    from contextlib import closing

    from bt_orchestrator.cli.journal_file import open_records
    from bt_orchestrator.view.report.account.bookkeeper import next_books

    with closing(open_records(journal)) as records:
        return next_books(records, log.warning)


def _has_stop(journal: JournalPlace, seq: int) -> bool:
    from contextlib import closing

    from bt_orchestrator.cli.journal_file import open_records
    from bt_orchestrator.view.report.account.bookkeeper import has_stop

    with closing(open_records(journal)) as records:
        return has_stop(records, seq, time.time(), log.warning)


def main() -> None:
    """Make books until the node has ended."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
