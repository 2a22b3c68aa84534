"""The effect of requests on jobs: runs the engine on without and with them."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, cast

from bt_orchestrator.asking.desk_here import DeskHere
from bt_orchestrator.asking.handler import RequestHandler
from bt_orchestrator.asking.recipes import RecipeOrders
from bt_orchestrator.errors import Refused, counted
from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, WorkOrder
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.requests import ADD, REQUEUE, Asked
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import (
    ActionTypes,
    CheckedOrder,
    Consequence,
    ExpectedJob,
    MadeScript,
    Moment,
    WrongField,
)
from bt_orchestrator.replies import begin
from bt_orchestrator.script.lookup import find_below
from bt_orchestrator.script.orders.by_recipe import recipes
from bt_orchestrator.script.orders.desk import ANY_PATH
from bt_orchestrator.script.orders.plain_order import bound, mistakes, order_from
from bt_orchestrator.script.parameter_uses import action_types
from bt_orchestrator.sim.made_before import MadeBefore, Make, choices_in
from bt_orchestrator.sim.run_on import LONGEST_S, RunOn

NOBODY = By('', 'what-if', '')


class EngineWhatIf:
    """Asks the engine itself, from one moment of a cell. Implements `ports.WhatIf`."""

    def __init__(
        self,
        moment: Moment,
        types: ActionTypes,
        trees: Sequence[Path] = (),
        recipes: Sequence[Path] = (),
        *,
        any_path: bool = True,
        make: Make | None = None,
    ) -> None:
        """Begin from a moment.

        :param trees: folders in which the scripts of new orders are looked up
        :param recipes: the same for recipes
        :param make: generates from them; None: nothing can be generated here
        :param any_path: whether an order may also name a script elsewhere, by its path
        """
        self._moment = moment
        self._types = types
        self._trees = trees
        self._recipes = recipes
        self._make = make
        self._made = MadeBefore(None, (), frozenset())
        self._any_path = any_path

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        Nothing is done, so anybody may ask anything; the roles decide when it is asked in earnest.
        """
        if any(choices_in(requests)) or any(asked.request == REQUEUE for asked in requests):
            with closing(self._begin()) as run:
                jobs = [job.job for job in run.state.jobs.values()]
            self._generate([*choices_in(requests, jobs)])
        with closing(self._begin()) as now:
            notes = tuple(_unlooked(now.state, requests))
            names_now = list(now.state.jobs)
            known_now_s = now.go_on(time.monotonic() + LONGEST_S)
        with closing(self._begin()) as then:
            refusals = tuple(self._refusals(then, requests))
            names_then = list(then.state.jobs)
            known_then_s = then.go_on(time.monotonic() + LONGEST_S)
            why_then = {name: then.unknown(name) for name in names_then}
        # Of a long queue one run may come farther: only what both know can be compared.
        by_s = min(known_now_s, known_then_s)
        before = self._ends(names_now, now.ends_s(by_s))
        after = self._ends(names_then, then.ends_s(by_s))
        unknown = {
            one.job: why_then[one.job] or 'the run without the requests was given up before'
            for one in after
            if one.ends_s is None
        }
        return Consequence(before, after, refusals, unknown, notes)

    def check(self, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order would be queued: it is read, and then the engine is asked."""
        wrong = mistakes(order)
        if wrong:
            return _with_mistakes(wrong)
        given = order_from(order)
        elsewhere = self._elsewhere(given)
        if elsewhere is not None:
            return CheckedOrder(True, elsewhere, is_checked=False)
        if given.recipe is not None:
            self._generate([given.recipe])
        with closing(self._begin()) as run:
            script = self._script(run, given)
            if isinstance(script, CheckedOrder):
                return script
            cell = run.state.cell
            job = bound(order, script, action_types(cell, self._types), cell.most_items)
            if not isinstance(job, Job):
                return _with_mistakes(job)
            if order.get('order') in run.state.jobs:
                used = WrongField('order', f'{job.id} is the id of another job', 'choose another')
                return _with_mistakes((used,))
            asked = Asked(ADD, NOBODY, {'orders': [given]})
            ((_, answer),) = self._answers(run, [asked])
            return CheckedOrder(answer.accepted, '' if answer.accepted else answer.message)

    def _elsewhere(self, order: WorkOrder) -> str | None:
        """Say why only the node can check an order: what it names is not here; None: it is."""
        if order.recipe is None:
            try:
                find_below(order.script, self._trees, ANY_PATH)
            except Refused as refused:
                return refused.findings[0].what
            return None
        if self._make is None:
            return 'no script is generated here'
        here = recipes().names(self._recipes)
        missing = [name for name in order.recipe.recipes if name not in here]
        return f'there is no recipe {missing[0]} here' if missing else None

    def _script(self, run: RunOn, order: WorkOrder) -> Script | CheckedOrder:
        """Return the script of an order, or what is wrong with it."""
        desk = self._desk(run)
        if order.recipe is None:
            named = desk.script(order.script)
            if isinstance(named, Script):
                return named
            return CheckedOrder(False, f'the script is {named.in_short}')
        (made,) = begin(self._made.make([order.recipe], _lost(run))).value
        script = desk.made(made) if isinstance(made, MadeScript) else made
        if isinstance(script, Script):
            return script
        if all(one.key for one in script.findings):
            wrong = [WrongField(one.key, one.what, one.hint) for one in script.findings]
            return _with_mistakes(wrong)
        return CheckedOrder(False, f'the recipe is {script.in_short}')

    def _generate(self, choices: Sequence[RecipeChoice]) -> None:
        """Have scripts generated for the runs to come."""
        with closing(self._begin()) as run:
            without = _lost(run)
        self._made = MadeBefore(self._make, choices, without)

    def _begin(self) -> RunOn:
        at = self._moment
        return RunOn(at.cell, self._types, at.plain_state, at.observed_s, at.now_s)

    def _desk(self, run: RunOn) -> DeskHere:
        state = run.state
        return DeskHere(state.cell, self._types, self._trees, state, any_path=self._any_path)

    def _answers(self, run: RunOn, requests: Sequence[Asked]) -> Iterator[tuple[Asked, Answer]]:
        orders = RecipeOrders(self._desk(run), self._made, run.state)
        handler = RequestHandler(run.orchestrator, self._types, orders)
        for asked in requests:
            anybody = replace(asked.sender, role=Role.ENGINEER, known=Known.LOCAL_USER)
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


def _lost(run: RunOn) -> frozenset[str]:
    """Return the components that are out of service."""
    return frozenset(run.state.out_of_service)


def _unlooked(state: CellState, requests: Sequence[Asked]) -> Iterator[str]:
    """Say which ids cannot be looked up: the content of sealed parts stays with the node."""
    added = (asked.arguments for asked in requests if asked.request == ADD)
    given: Iterator[Any] = chain.from_iterable(cast('Any', one['orders']) for one in added)
    names = [one.order for one in given if one.order and one.order not in state.order_ids]
    if names and state.order_ids.sealed:
        ids = listed(names, '')
        yield f'whether {ids} was used before is not known here: the node alone has the oldest ids'


def _with_mistakes(wrong: Sequence[WrongField]) -> CheckedOrder:
    return CheckedOrder(False, counted(len(wrong), 'mistake'), tuple(wrong))
