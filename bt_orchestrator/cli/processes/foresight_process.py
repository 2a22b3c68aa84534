"""Forecasts of a running cell, made in a process of low priority.

The engine that runs the cell and the one that looks ahead share nothing: the blackboard of
py_trees is global to a process, and a virtual run would take the interpreter from the tick thread.
The cell is sent first, then questions come, and an answer to each; all of it is JSON.
"""

from __future__ import annotations

import json
import logging
import threading
import time
from collections.abc import Mapping
from typing import Any

from bt_orchestrator.base.child_process import (
    FAREWELL_S,
    ChildFailed,
    ChildProcess,
    be_modest,
    serve,
)
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_plain, to_plain

log = logging.getLogger(__name__)

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""


class ForesightProcess:
    """Asks the process, from a thread that only waits. Implements `ports.Foresight`."""

    def __init__(self, cell: Cell) -> None:
        """Start the process: it loads for half a second, which a line at work would feel."""
        self._process = ChildProcess(__name__, json.dumps(to_plain(cell)).encode())
        self._news = threading.Condition()
        self._question: str | None = None
        self._closed = False
        self._ends_s: Mapping[str, float] = {}
        self._took_s = 0.0
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    @property
    def ends_s(self) -> Mapping[str, float]:
        """When each live job will end, by the last answer."""
        return self._ends_s

    @property
    def took_s(self) -> float:
        """How many seconds the last answer took; 0: there was none."""
        return self._took_s

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        """Put a question; it replaces one that was not taken up yet."""
        known = json.dumps({'now_s': now_s, 'observed_s': observed_s})
        with self._news:
            self._question = f'{{"known": {known}, "state": {state}}}'
            self._news.notify()

    def close(self) -> None:
        """End the process and wait for it."""
        with self._news:
            self._closed = True
            self._news.notify()
        self._process.close()
        self._thread.join(FAREWELL_S)

    def _serve(self) -> None:
        try:
            self._process.ready()
            while (question := self._next()) is not None:
                began_s = time.monotonic()
                self._ends_s = json.loads(self._process.ask(question.encode()))
                self._took_s = time.monotonic() - began_s
        except ChildFailed as error:
            if not self._closed:
                log.warning('no more forecasts: %s', error)
        self._ends_s = {}

    def _next(self) -> str | None:
        """Wait for a question; None: there will be none."""
        with self._news:
            self._news.wait_for(lambda: self._closed or self._question is not None)
            question, self._question = self._question, None
            return None if self._closed else question


class _Answers:
    """The knowledge of the process: the engine, and the cell of the first question."""

    def __init__(self) -> None:
        from bt_orchestrator.ros.types.action_types import InstalledActionTypes
        from bt_orchestrator.sim.run_on import expected_ends

        self._expected_ends = expected_ends
        self._types = InstalledActionTypes()
        self._cell: Cell | None = None

    def __call__(self, question: bytes) -> bytes:
        plain = json.loads(question)
        if self._cell is None:
            self._cell = from_plain(Cell, plain)
            for component in self._cell.components.values():
                self._types.action(component.type)
            return b''
        return json.dumps(self._answer(self._cell, plain)).encode()

    def _answer(self, cell: Cell, question: Mapping[str, Any]) -> dict[str, float]:
        """Answer one question; one that cannot be answered leaves everything unknown."""
        try:
            known = question['known']
            return self._expected_ends(cell, self._types, question['state'], **known)
        except Exception as error:  # noqa: BLE001 - a forecast is not worth a node that ends
            log.warning('no forecast: %r', error)
            return {}


def main() -> None:
    """Answer questions until the last one, or until the node has ended."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
