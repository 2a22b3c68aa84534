"""Forecasts of a running cell, made in a process of low priority.

The engine that runs the cell and the one that looks ahead share nothing: the blackboard of
py_trees is global to a process, and a virtual run would take the interpreter from the tick thread.
One JSON object a line goes each way: first the cell, then questions, and an answer to each.
"""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Mapping
from typing import Any

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_plain, to_plain

log = logging.getLogger(__name__)

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""

FAREWELL_S = 2.0


class ForesightProcess:
    """Asks the process, from a thread that only waits. Implements `ports.Foresight`."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._process: subprocess.Popen[str] | None = None
        self._thread: threading.Thread | None = None
        self._news = threading.Condition()
        self._question: str | None = None
        self._closed = False
        self._ends_s: Mapping[str, float] = {}

    @property
    def ends_s(self) -> Mapping[str, float]:
        """When each live job will end, by the last answer."""
        return self._ends_s

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        """Put a question; it replaces one that was not taken up yet."""
        known = json.dumps({'now_s': now_s, 'observed_s': observed_s})
        with self._news:
            self._question = f'{{"known": {known}, "state": {state}}}\n'
            self._news.notify()
        if self._thread is None and not self._closed:
            self._thread = threading.Thread(target=self._serve, daemon=True)
            self._thread.start()

    def close(self) -> None:
        """End the process and wait for it."""
        with self._news:
            self._closed = True
            self._news.notify()
            if self._process is not None:
                self._process.terminate()
        if self._thread is not None:
            self._thread.join(FAREWELL_S)

    def _serve(self) -> None:
        try:
            with self._begin() as process:
                self._converse(process)
                process.terminate()
        except (OSError, ValueError) as error:
            if not self._closed:
                log.warning('no more forecasts: their process ended (%s)', error)
        self._ends_s = {}

    def _begin(self) -> subprocess.Popen[str]:
        """Start the process, unless nobody wants it any more."""
        with self._news:
            if self._closed:
                raise ValueError('nobody asks any more')
            self._process = subprocess.Popen(
                [sys.executable, '-m', __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                start_new_session=True,  # Ctrl-C is for the node, which ends this process itself
            )
            return self._process

    def _converse(self, process: subprocess.Popen[str]) -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(json.dumps(to_plain(self._cell)) + '\n')
        while (question := self._next()) is not None:
            process.stdin.write(question)
            process.stdin.flush()
            self._ends_s = json.loads(process.stdout.readline())

    def _next(self) -> str | None:
        """Wait for a question; None: there will be none."""
        with self._news:
            self._news.wait_for(lambda: self._closed or self._question is not None)
            question, self._question = self._question, None
            return None if self._closed else question


def answer(cell: Cell, types: Any, question: Mapping[str, Any]) -> dict[str, float]:
    """Answer one question; one that cannot be answered leaves everything unknown."""
    from bt_orchestrator.sim.foresight import expected_ends

    try:
        return expected_ends(cell, types, question['state'], **question['known'])
    except Exception as error:  # noqa: BLE001 - a forecast is not worth a node that ends
        log.warning('no forecast: %r', error)
        return {}


def main() -> None:
    """Answer questions until there are no more, or nobody is left to hear the answers."""
    os.nice(NICE)
    try:
        _serve()
    except BrokenPipeError:
        # What is left in the buffer has nowhere to go, and Python would complain at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _serve() -> None:
    from bt_orchestrator.ros.action_types import InstalledActionTypes

    types = InstalledActionTypes()
    cell = from_plain(Cell, json.loads(sys.stdin.readline()))
    for line in iter(sys.stdin.readline, ''):
        print(json.dumps(answer(cell, types, json.loads(line))), flush=True)


if __name__ == '__main__':
    main()
