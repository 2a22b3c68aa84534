"""The effect of requests on jobs: runs the engine on without and with them."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from bt_orchestrator.asking.desk_here import DeskHere
from bt_orchestrator.asking.handler import RequestHandler
from bt_orchestrator.model.by import Known
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.roles import Role
from bt_orchestrator.ports import ActionTypes, Consequence, ExpectedJob, Moment
from bt_orchestrator.replies import begin
from bt_orchestrator.sim.run_on import LONGEST_S, RunOn


class EngineWhatIf:
    """Asks the engine itself, from one moment of a cell. Implements `ports.WhatIf`."""

    def __init__(self, moment: Moment, types: ActionTypes, trees: Sequence[Path] = ()) -> None:
        """Begin from a moment.

        :param trees: folders in which the scripts of new orders are looked up
        """
        self._moment = moment
        self._types = types
        self._trees = trees

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        Nothing is done, so anybody may ask anything; the roles decide when it is asked in earnest.
        """
        with closing(self._begin()) as run:
            before = self._ends(run)
        with closing(self._begin()) as run:
            refusals = tuple(self._refusals(run, requests))
            return Consequence(before, self._ends(run), refusals)

    def _begin(self) -> RunOn:
        at = self._moment
        return RunOn(at.cell, self._types, at.plain_state, at.observed_s, at.now_s)

    def _refusals(self, run: RunOn, requests: Sequence[Asked]) -> Iterator[str]:
        desk = DeskHere(run.state.cell, self._types, self._trees, run.state)
        handler = RequestHandler(run.orchestrator, self._types, desk)
        for asked in requests:
            anybody = replace(asked.by, role=Role.ENGINEER, known=Known.LOCAL_USER)
            answer = begin(handler.carry_out(replace(asked, by=anybody))).value
            if not answer.accepted:
                findings = (finding for order in answer.orders for finding in order.findings)
                yield '; '.join([f'{asked.request.name}: {answer.message}', *findings])

    def _ends(self, run: RunOn) -> tuple[ExpectedJob, ...]:
        names = list(run.state.jobs)
        ends_s = run.ends_s(time.monotonic() + LONGEST_S)
        return tuple(
            ExpectedJob(name, ends_s[name] - self._moment.now_s if name in ends_s else None)
            for name in names
        )
