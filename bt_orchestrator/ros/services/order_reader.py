"""Work orders that come over ROS 2: read in a process of their own, one request after another.

The tick thread hands requests over and takes the answers; a thread that only waits asks the
process.
"""

from __future__ import annotations

import contextlib
import logging
import pickle
import queue
import threading
from collections import OrderedDict, deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import asynccontextmanager
from functools import partial
from typing import NamedTuple

from bt_orchestrator.base.child_process import FAREWELL_S, ChildFailed, ChildProcess, ChildTooLate
from bt_orchestrator.base.errors import NotRead
from bt_orchestrator.base.replies import Reply
from bt_orchestrator.engine.asking.orders import free_ids
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.orders.desk import ChangedJob, Question, Reading, Wanted
from bt_orchestrator.script.orders.desk_pickles import name_of, unpickled

log = logging.getLogger(__name__)

READ_WITHIN_S = 10.0
"""Longest time for one request; a script of 2,000 tasks takes a tenth of it."""

MOST_WAITING = 200
"""Requests that wait to be read."""

SCRIPTS_KEPT = 32
"""Scripts that need not be sent again, beside those of live jobs."""

LATE = sentence('reading_late', seconds=f'{READ_WITHIN_S:g}')
BUSY = sentence('reading_busy', count=MOST_WAITING)

ToRead = Wanted | Callable[[], Wanted]
"""The text to read, or a function that gives it when its turn has come; it may raise NotRead."""


class _Asked(NamedTuple):
    question: Question
    held: Mapping[str, Script]
    outcome: Reply[Reading | NotRead]


class OrderReader:
    """Has orders read in the order in which they came. Nothing is changed here."""

    def __init__(
        self,
        state: CellState,
        process: ChildProcess,
        soon: Callable[[Callable[[], None]], None],
    ) -> None:
        """Start the process: it is then ready for the first order.

        :param soon: lets the tick thread call something; called by another thread
        """
        self._state = state
        self._process = process
        self._soon = soon
        self._turns: deque[Reply[None]] = deque()
        """Of requests that wait to be read, oldest first."""
        self._is_reading = False
        self._gives_turns = False
        self._scripts: OrderedDict[str, Script] = OrderedDict()
        self._pickled: dict[str, bytes] = {}
        self._questions: queue.SimpleQueue[_Asked | None]
        self._questions = queue.SimpleQueue()
        self._closed = False
        self._thread = threading.Thread(target=self._ask_all, daemon=True)
        self._thread.start()

    @asynccontextmanager
    async def read(self, wanted: ToRead) -> AsyncIterator[Reading]:
        """Have orders read in their turn; that of the next ones comes when the block has ended.

        So ids are assigned to the next ones when it is on record what became of these.

        :raises NotRead: says why nothing was read
        """
        await self._turn()
        try:
            live = {name_of(script): script for script in self._state.scripts.values()}
            held = {**self._scripts, **live}
            question = self._question(wanted() if callable(wanted) else wanted, held)
            asked = _Asked(question, held, Reply())
            self._questions.put(asked)
            reading = await asked.outcome
            if isinstance(reading, NotRead):
                raise reading
            self._keep(reading)
            yield reading
        finally:
            self._give_turns()

    def close(self) -> None:
        """Stop reading, and end the process."""
        self._closed = True
        self._questions.put(None)
        self._process.close()
        self._thread.join(FAREWELL_S)

    async def _turn(self) -> None:
        if self._is_reading:
            if len(self._turns) >= MOST_WAITING:
                raise NotRead(BUSY)
            self._turns.append(turn := Reply[None]())
            await turn
        self._is_reading = True

    def _give_turns(self) -> None:
        """Let the next request be read, and those after it that end at once."""
        self._is_reading = False
        if self._gives_turns:
            return  # one of them has ended within the loop below
        self._gives_turns = True
        try:
            while self._turns and not self._is_reading:
                self._turns.popleft().give(None)
        finally:
            self._gives_turns = False

    def _question(self, wanted: Wanted, held: Mapping[str, Script]) -> Question:
        live = tuple(name for name, script in self._state.scripts.items() if script.dependencies)
        return Question(
            wanted,
            free_ids(wanted, self._state),
            live,
            self._sent({*live, *_changed(wanted)}),
            frozenset(held),
        )

    def _sent(self, names: set[str]) -> Mapping[str, bytes]:
        """Return scripts of live jobs for the process, which may be a new one.

        Made here: what a script works out about itself is added to it in this thread.
        """
        self._pickled = {
            name: self._pickled.get(name) or pickle.dumps(self._state.scripts[name])
            for name in names
        }
        return self._pickled

    def _keep(self, reading: Reading) -> None:
        for job in reading.read:
            if isinstance(job, Job):
                self._scripts[name_of(job.script)] = job.script
        while len(self._scripts) > SCRIPTS_KEPT:
            self._scripts.popitem(last=False)

    # --- in the thread that waits -----------------------------------------------------------

    def _ask_all(self) -> None:
        with contextlib.suppress(ChildFailed):
            self._process.ready()  # told with the first order that cannot be read for it
        while (asked := self._questions.get()) is not None:
            outcome = self._ask(asked.question, asked.held)
            if not self._closed:
                self._soon(partial(asked.outcome.give, outcome))

    def _ask(self, question: Question, held: Mapping[str, Script]) -> Reading | NotRead:
        why = ''
        for _ in range(2):  # somebody may have ended the process, or it took too much memory
            try:
                answer = self._process.ask(pickle.dumps(question), READ_WITHIN_S)
                reading = unpickled(answer, held)
                assert isinstance(reading, (Reading, NotRead))
                return reading
            except ChildTooLate:
                return NotRead(LATE)
            except Exception as error:  # noqa: BLE001 - the node goes on without orders
                why = str(error) or repr(error)
        if not self._closed:
            log.error('orders cannot be read: %s', why)
        return NotRead(sentence('reading_failed', words=why))


def _changed(wanted: Wanted) -> Iterator[str]:
    """Yield the script of a job that is to be changed."""
    if isinstance(wanted, ChangedJob):
        yield wanted.script
