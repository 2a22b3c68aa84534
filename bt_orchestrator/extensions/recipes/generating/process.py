"""Scripts of orders by recipe, generated in a process of low priority.

A search may take seconds: it takes neither the tick thread's interpreter, nor the process that
reads orders by script. Recipes are read there, too, when they are asked for.
"""

from __future__ import annotations

import logging
import pickle
import queue
import threading
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.child_process import (
    FAREWELL_S,
    ChildProcess,
    ChildTooLate,
    be_modest,
    serve,
)
from bt_orchestrator.base.errors import NotRead, Refused
from bt_orchestrator.base.replies import Reply
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.limits import GENERATING_S
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import MadeScript

log = logging.getLogger(__name__)

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""

MOST_WAITING = 50
"""Requests that wait for their scripts."""

LATE = sentence('making_late', seconds=f'{GENERATING_S:g}')
BUSY = sentence('making_busy', count=MOST_WAITING)

_Scripts = tuple['MadeScript | Refused', ...]


class _Asked(NamedTuple):
    choices: tuple[RecipeChoice, ...]
    without: frozenset[str]
    outcome: Reply[_Scripts | NotRead]


class GeneratingProcess:
    """Asks the process, from a thread that only waits. Implements `ports.Generating`.

    Thread and process start with the first request; nobody else waits for them.
    """

    def __init__(
        self, cell: Cell, recipes: Sequence[Path], soon: Callable[[Callable[[], None]], None]
    ) -> None:
        """Prepare; nothing is started yet.

        :param recipes: folders in which recipes are looked up
        :param soon: lets the tick thread call something; called by another thread
        """
        self._process = ChildProcess(__name__, pickle.dumps((cell, tuple(recipes))))
        self._soon = soon
        self._asked: queue.SimpleQueue[_Asked | None] = queue.SimpleQueue()
        self._waiting = 0
        self._thread: threading.Thread | None = None
        self._closed = False

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        """Return the script of each, or why there is none.

        :raises NotRead: says why nothing could be generated
        """
        if self._waiting >= MOST_WAITING:
            raise NotRead(BUSY)
        if self._thread is None:
            self._thread = threading.Thread(target=self._serve, daemon=True)
            self._thread.start()
        asked = _Asked(tuple(choices), without, Reply())
        self._waiting += 1
        self._asked.put(asked)
        outcome = await asked.outcome
        self._waiting -= 1
        if isinstance(outcome, NotRead):
            raise outcome
        return outcome

    def close(self) -> None:
        """Stop generating, and end the process."""
        self._closed = True
        self._asked.put(None)
        self._process.close()
        if self._thread is not None:
            self._thread.join(FAREWELL_S)

    # --- in the thread that waits -----------------------------------------------------------

    def _serve(self) -> None:
        while (asked := self._asked.get()) is not None:
            outcome = self._ask(asked)
            if not self._closed:
                self._soon(partial(asked.outcome.give, outcome))

    def _ask(self, asked: _Asked) -> _Scripts | NotRead:
        try:
            answer = self._process.ask(pickle.dumps((asked.choices, asked.without)), GENERATING_S)
            outcome: _Scripts | NotRead = pickle.loads(answer)
            return outcome
        except ChildTooLate:
            return NotRead(LATE)
        except Exception as error:  # noqa: BLE001 - the next request is made
            why = str(error) or repr(error)
        if not self._closed:
            log.error('no script can be generated: %s', why)
        return NotRead(sentence('making_failed', words=why))


class _Answers:
    """The knowledge of the process: the cell and the folders of the first question."""

    def __init__(self) -> None:
        from bt_orchestrator.extensions.recipes.generating.ordered import RecipeMaker
        from bt_orchestrator.ros.types.action_types import InstalledActionTypes

        self._types = InstalledActionTypes()
        self._begin = RecipeMaker
        self._maker: RecipeMaker | None = None

    def __call__(self, data: bytes) -> bytes:
        asked = pickle.loads(data)
        if self._maker is None:
            cell, recipes = asked
            self._maker = self._begin(cell, self._types, recipes)
            return b''
        choices, without = asked
        try:
            return pickle.dumps(tuple(self._maker.script(choice, without) for choice in choices))
        except MemoryError:
            why = 'generating this takes more memory than a request may have; give fewer orders'
        except Exception as error:  # noqa: BLE001 - told to the client, and the next one is made
            why = f'generating this failed, which is a defect of the orchestrator: {error!r}'
        return pickle.dumps(NotRead(why))


def main() -> None:
    """Generate until the reader of the answers is gone."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
