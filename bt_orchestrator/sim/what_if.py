"""What would become of jobs after some requests: the engine, run on once without and once with."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import Any

from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer, Command
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import ActionTypes, Consequence, ExpectedJob
from bt_orchestrator.sim.run_on import RunOn

LONGEST_S = 10.0
"""Real seconds for each of both runs; jobs that have not ended then have no forecast."""


class EngineWhatIf:
    """Asks the engine itself, from one moment of a cell. Implements `ports.WhatIf`."""

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        plain_state: Mapping[str, Any],
        observed_s: Mapping[str, Mapping[str, float]],
        now_s: float,
        command_of: Callable[[Asked, CellState], Command],
    ) -> None:
        """Begin from a moment.

        :param plain_state: of `model.snapshot`
        :param observed_s: seconds that tasks took, by component and task constant
        :param now_s: that moment on the clock of the state
        :param command_of: makes a command of a request, reads orders, and raises an
            `OrchestratorError` with what is wrong with it
        """
        self._begin = partial(RunOn, cell, types, plain_state, observed_s, now_s)
        self._now_s = now_s
        self._command_of = command_of

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests."""
        with closing(self._begin()) as run:
            before = self._ends(run)
        with closing(self._begin()) as run:
            refusals = tuple(self._refusals(run, requests))
            return Consequence(before, self._ends(run), refusals)

    def _refusals(self, run: RunOn, requests: Sequence[Asked]) -> Iterator[str]:
        for asked in requests:
            answer = self._carry_out(run, asked)
            if not answer.accepted:
                yield f'{asked.request.name}: {answer.message}'

    def _carry_out(self, run: RunOn, asked: Asked) -> Answer:
        try:
            command = self._command_of(asked, run.state)
        except OrchestratorError as error:
            return Answer(False, str(error))
        (answer,) = run.ask([command])
        return answer

    def _ends(self, run: RunOn) -> tuple[ExpectedJob, ...]:
        names = list(run.state.jobs)
        ends_s = run.ends_s(time.monotonic() + LONGEST_S)
        return tuple(
            ExpectedJob(name, ends_s[name] - self._now_s if name in ends_s else None)
            for name in names
        )
