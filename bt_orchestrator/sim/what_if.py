"""The effect of requests on jobs: runs the engine on without and with them."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from bt_orchestrator.asking.desk_here import DeskHere
from bt_orchestrator.asking.handler import RequestHandler
from bt_orchestrator.errors import Refused, counted
from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import ADD, Asked
from bt_orchestrator.model.roles import Role
from bt_orchestrator.ports import (
    ActionTypes,
    CheckedOrder,
    Consequence,
    ExpectedJob,
    Moment,
    WrongField,
)
from bt_orchestrator.replies import begin
from bt_orchestrator.script.lookup import find_below
from bt_orchestrator.script.orders.desk import ANY_PATH
from bt_orchestrator.script.orders.plain_order import bound, mistakes, order_from
from bt_orchestrator.script.parameter_uses import action_types
from bt_orchestrator.sim.run_on import LONGEST_S, RunOn

NOBODY = By('', 'what-if', '')


class EngineWhatIf:
    """Asks the engine itself, from one moment of a cell. Implements `ports.WhatIf`."""

    def __init__(
        self,
        moment: Moment,
        types: ActionTypes,
        trees: Sequence[Path] = (),
        *,
        any_path: bool = True,
    ) -> None:
        """Begin from a moment.

        :param trees: folders in which the scripts of new orders are looked up
        :param any_path: whether an order may also name a script elsewhere, by its path
        """
        self._moment = moment
        self._types = types
        self._trees = trees
        self._any_path = any_path

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        Nothing is done, so anybody may ask anything; the roles decide when it is asked in earnest.
        """
        with closing(self._begin()) as now:
            names_now = list(now.state.jobs)
            known_now_s = now.go_on(time.monotonic() + LONGEST_S)
        with closing(self._begin()) as then:
            refusals = tuple(self._refusals(then, requests))
            names_then = list(then.state.jobs)
            known_then_s = then.go_on(time.monotonic() + LONGEST_S)
        # Of a long queue one run may come farther: only what both know can be compared.
        by_s = min(known_now_s, known_then_s)
        before = self._ends(names_now, now.ends_s(by_s))
        return Consequence(before, self._ends(names_then, then.ends_s(by_s)), refusals)

    def check(self, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order would be queued: it is read, and then the engine is asked."""
        wrong = mistakes(order)
        if wrong:
            return _with_mistakes(wrong)
        if 'recipe' in order:
            what = 'its script is made when the order is given'
            return CheckedOrder(True, what, is_checked=False)
        name = str(order['script'])
        try:
            find_below(name, self._trees, ANY_PATH)
        except Refused as refused:
            return CheckedOrder(True, refused.findings[0].what, is_checked=False)
        with closing(self._begin()) as run:
            script = self._desk(run).script(name)
            if isinstance(script, Refused):
                return CheckedOrder(False, f'the script is {script.in_short}')
            job = bound(order, script, action_types(run.state.cell, self._types))
            if not isinstance(job, Job):
                return _with_mistakes(job)
            if order.get('order') in run.state.jobs:
                used = WrongField('order', f'{job.id} is the id of another job', 'choose another')
                return _with_mistakes((used,))
            asked = Asked(ADD, NOBODY, {'orders': [order_from(order)]})
            ((_, answer),) = self._answers(run, [asked])
            return CheckedOrder(answer.accepted, '' if answer.accepted else answer.message)

    def _begin(self) -> RunOn:
        at = self._moment
        return RunOn(at.cell, self._types, at.plain_state, at.observed_s, at.now_s)

    def _desk(self, run: RunOn) -> DeskHere:
        state = run.state
        return DeskHere(state.cell, self._types, self._trees, state, any_path=self._any_path)

    def _answers(self, run: RunOn, requests: Sequence[Asked]) -> Iterator[tuple[Asked, Answer]]:
        handler = RequestHandler(run.orchestrator, self._types, self._desk(run))
        for asked in requests:
            anybody = replace(asked.by, role=Role.ENGINEER, known=Known.LOCAL_USER)
            yield asked, begin(handler.carry_out(replace(asked, by=anybody))).value

    def _refusals(self, run: RunOn, requests: Sequence[Asked]) -> Iterator[str]:
        for asked, answer in self._answers(run, requests):
            if not answer.accepted:
                findings = (finding for order in answer.orders for finding in order.findings)
                yield '; '.join([f'{asked.request.name}: {answer.message}', *findings])

    def _ends(self, names: Sequence[str], ends_s: Mapping[str, float]) -> tuple[ExpectedJob, ...]:
        return tuple(
            ExpectedJob(name, ends_s[name] - self._moment.now_s if name in ends_s else None)
            for name in names
        )


def _with_mistakes(wrong: Sequence[WrongField]) -> CheckedOrder:
    return CheckedOrder(False, counted(len(wrong), 'mistake'), tuple(wrong))
