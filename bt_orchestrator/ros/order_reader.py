"""Work orders that come over ROS 2: read in a process of their own, one request after another.

The tick thread hands requests over and takes the answers; a thread that only waits asks the
process. What is to be done with an answer is written as steps: a generator that yields what it
wants read, and is sent what became of it.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import pickle
import queue
import threading
from collections import OrderedDict, deque
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from bt_orchestrator.child_process import FAREWELL_S, ChildFailed, ChildProcess, ChildTooLate
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ros.order_process import NotRead
from bt_orchestrator.script.desk_pickles import unpickled
from bt_orchestrator.script.order_desk import ChangedJob, Question, Reading, Wanted

log = logging.getLogger(__name__)

PREFIX = 'WO-'
"""Of the ids that are assigned to orders without one."""

READ_WITHIN_S = 10.0
"""Longest time for one request; a script of 2,000 tasks takes a tenth of it."""

MOST_WAITING = 200
"""Requests that wait to be read."""

SCRIPTS_KEPT = 32
"""Scripts that need not be sent again, beside those of live jobs."""

LATE = (
    f'reading this took longer than {READ_WITHIN_S:g} s and was given up; try the script with '
    'bt-orchestrator check, or give fewer orders at a time'
)
BUSY = (
    f'{MOST_WAITING} requests with orders wait to be read; give this one again when some of them '
    'are answered'
)

ToRead = Wanted | Callable[[], Wanted]
"""What to read, or what says that when its turn has come; it may raise NotRead."""

Steps = Generator[ToRead, Reading, None]
"""May raise what a request makes it raise, and is told by NotRead that nothing was read."""


@dataclass(frozen=True)
class _Waiting:
    steps: Steps
    wanted: ToRead
    ended: Callable[[Exception | None], None]


class OrderReader:
    """Has orders read in the order in which they came. Nothing is changed here."""

    def __init__(
        self,
        state: CellState,
        process: ChildProcess,
        soon: Callable[[Callable[[], None]], None],
    ) -> None:
        """Start the process, so that it is ready for the first order.

        :param soon: lets the tick thread call something; called by another thread
        """
        self._state = state
        self._process = process
        self._soon = soon
        self._waiting: deque[_Waiting] = deque()
        self._current: _Waiting | None = None
        self._scripts: OrderedDict[str, Script] = OrderedDict()
        self._pickled: dict[str, bytes] = {}
        self._questions: queue.SimpleQueue[tuple[Question, Mapping[str, Script]] | None]
        self._questions = queue.SimpleQueue()
        self._closed = False
        self._thread = threading.Thread(target=self._ask_all, daemon=True)
        self._thread.start()

    def follow(self, steps: Steps, ended: Callable[[Exception | None], None]) -> None:
        """Take steps, with what they want read in between.

        :param ended: called at their end, with the exception that ended them; may be at once
        """
        try:
            wanted = next(steps)
        except StopIteration:
            ended(None)
        except Exception as error:  # noqa: BLE001 - a bad request never stops the node
            ended(error)
        else:
            self._put(_Waiting(steps, wanted, ended))

    def close(self) -> None:
        """Read no more, and end the process."""
        self._closed = True
        self._questions.put(None)
        self._process.close()
        self._thread.join(FAREWELL_S)

    def _put(self, waiting: _Waiting) -> None:
        if len(self._waiting) >= MOST_WAITING:
            self._go_on(waiting, NotRead(BUSY))
            return
        self._waiting.append(waiting)
        self._begin()

    def _begin(self) -> None:
        """Have the next one read, unless one is being read."""
        if self._current is not None or not self._waiting:
            return
        self._current = self._waiting.popleft()
        wanted = self._current.wanted
        try:
            held = {**self._scripts, **self._state.scripts}
            question = self._question(wanted() if callable(wanted) else wanted, held)
        except NotRead as why:
            self._finish(why)
        else:
            self._questions.put((question, held))

    def _question(self, wanted: Wanted, held: Mapping[str, Script]) -> Question:
        named = tuple(wanted.named)
        nameless = sum(not name for name in named)
        taken = frozenset(named)
        free = (name for name in self._state.order_ids.free(PREFIX) if name not in taken)
        live = tuple(name for name, one in self._state.scripts.items() if one.dependencies)
        return Question(
            wanted,
            tuple(itertools.islice(free, nameless)),
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

    def _finish(self, outcome: Reading | NotRead) -> None:
        """Go on with what was read, and with the next request."""
        waiting, self._current = self._current, None
        assert waiting is not None
        if isinstance(outcome, Reading):
            self._keep(outcome)
        try:
            self._go_on(waiting, outcome)
        finally:
            self._begin()

    def _keep(self, reading: Reading) -> None:
        for job in reading.read:
            if isinstance(job, Job):
                self._scripts[digest(job.script)] = job.script
        while len(self._scripts) > SCRIPTS_KEPT:
            self._scripts.popitem(last=False)

    def _go_on(self, waiting: _Waiting, outcome: Reading | NotRead) -> None:
        error: Exception | None = None
        try:
            if isinstance(outcome, NotRead):
                waiting.steps.throw(outcome)
            else:
                waiting.steps.send(outcome)
            waiting.steps.close()
        except StopIteration:
            pass
        except Exception as raised:  # noqa: BLE001 - a bad request never stops the node
            error = raised
        waiting.ended(error)

    # --- in the thread that waits -----------------------------------------------------------

    def _ask_all(self) -> None:
        with contextlib.suppress(ChildFailed):
            self._process.ready()  # told with the first order that cannot be read for it
        while (asked := self._questions.get()) is not None:
            outcome = self._ask(*asked)
            if not self._closed:
                self._soon(partial(self._finish, outcome))

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
        return NotRead(
            f'orders cannot be read now: {why}, twice; give this one again, and see whether the '
            'machine of the node has memory and processes left'
        )


def _changed(wanted: Wanted) -> Iterator[str]:
    """Yield the script of a job that is to be changed."""
    if isinstance(wanted, ChangedJob):
        yield wanted.script
