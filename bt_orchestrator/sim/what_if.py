"""The effect of requests on jobs: runs the engine on without and with them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any, cast

from bt_orchestrator.base.errors import Refused, counted
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.orders import DeskHere
from bt_orchestrator.engine.asking.recipes import WHO, QueueAnew, RecipeOrders
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, WorkOrder
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import (
    ActionTypes,
    CheckedOrder,
    Consequence,
    ExpectedJob,
    MadeScript,
    Moment,
    Proposal,
    WrongField,
)
from bt_orchestrator.script.lookup import find_below
from bt_orchestrator.script.orders.by_recipe import recipes
from bt_orchestrator.script.orders.desk import ANY_PATH
from bt_orchestrator.script.orders.parameter_uses import action_types
from bt_orchestrator.script.orders.plain_order import bound, draft_of
from bt_orchestrator.sim.made_before import MadeBefore, Make
from bt_orchestrator.sim.proposing import Proposing
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
        self._made = MadeBefore(make)
        self._any_path = any_path

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        Nothing is done, so anybody may ask anything; the roles decide when it is asked in earnest.
        """
        with closing(self._after(()).run) as now:
            notes = [*_unlooked(now.state, requests)]
            names_now, due_s = list(now.state.jobs), self._due_s(now.state)
            known_now_s = now.go_on(time.monotonic() + LONGEST_S)
        asked = self._after(requests)
        with closing(asked.run) as then:
            rests = {job.rest_of: name for name, job in then.state.jobs.items() if job.rest_of}
            names_then = list(then.state.jobs)
            due_s |= self._due_s(then.state)
            known_then_s = then.go_on(time.monotonic() + LONGEST_S)
            why_then = {
                name: '; '.join(filter(None, [then.unknown(name), asked.not_anew.get(name)]))
                for name in names_then
            }
        # Of a long queue one run may come farther: only what both know can be compared.
        by_s = min(known_now_s, known_then_s)
        before = self._ends(names_now, now.ends_s(by_s))
        after = self._ends(names_then, then.ends_s(by_s))
        unknown = {
            end.job: why_then[end.job] or 'the run without the requests was given up before'
            for end in after
            if end.ends_s is None
        }
        notes += _with_rests(rests, dict(before), dict(after))
        return Consequence(before, after, asked.refusals, unknown, tuple(notes), due_s)

    def propose(self) -> Proposal:
        """Propose an order of the queue; nothing is done."""
        return Proposing(self._begin, self._moment.now_s).propose()

    def check(self, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order would be queued: it is read, and then the engine is asked."""
        given, wrong = draft_of(order)
        if given is None:
            return _with_mistakes(wrong)
        result = self._checked(order, given, wrong)
        if given.recipe is None or not any(
            _is_of_choice(mistake.field) for mistake in result.wrong
        ):
            return result
        # Without them another script is made, which tells what else is wrong.
        plain = replace(given, recipe=RecipeChoice(given.recipe.recipes))
        more = self._checked(order, plain, wrong)
        return _with_mistakes(tuple(dict.fromkeys((*result.wrong, *more.wrong))))

    def _checked(
        self, order: Mapping[str, object], given: WorkOrder, wrong: tuple[WrongField, ...]
    ) -> CheckedOrder:
        elsewhere = self._elsewhere(given)
        if elsewhere is not None:
            unchecked = CheckedOrder(True, elsewhere, is_checked=False)
            return _with_mistakes(wrong) if wrong else unchecked
        if given.recipe is not None:
            with closing(self._begin()) as run:
                without = _lost(run)
            self._made.generate((given.recipe, without))
        with closing(self._begin()) as run:
            script = self._script(run, given)
            if isinstance(script, CheckedOrder):
                return _with_mistakes((*wrong, *script.wrong)) if wrong else script
            types = action_types(run.state.cell, self._types)
            job = bound(order, script, types, run.state.cell.most_items)
            if not isinstance(job, Job):
                return _with_mistakes(job)
            if order.get('order') in run.state.jobs:
                used = WrongField('order', sentence('id_used', job=job.id), sentence('id_other'))
                return _with_mistakes((used,))
            asked = ask('queue.add', NOBODY, orders=[given])
            answer = self._node(run).answer(asked)
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
        if all(finding.key for finding in script.findings):
            wrong = [
                WrongField(finding.key, finding.what, finding.hint) for finding in script.findings
            ]
            return _with_mistakes(wrong)
        return CheckedOrder(False, f'the recipe is {script.in_short}')

    def _begin(self) -> RunOn:
        at = self._moment
        return RunOn(at.cell, self._types, at.plain_state, at.observed_s, at.now_s)

    def _desk(self, run: RunOn) -> DeskHere:
        state = run.state
        return DeskHere(state.cell, self._types, self._trees, state, any_path=self._any_path)

    def _node(self, run: RunOn) -> _Node:
        orders = RecipeOrders(self._desk(run), self._made, run.state)
        return _Node(run, RequestHandler(run.orchestrator, self._types, orders))

    def _after(self, requests: Sequence[Asked]) -> _Node:
        """Return a run that has heard some requests; the scripts for it are generated before."""
        while True:
            node = self._node(self._begin())
            node.hear(requests)
            if not self._made.lacks:
                return node
            node.run.close()
            self._made.generate()

    def _due_s(self, state: CellState) -> dict[str, float]:
        dues = {name: job.job.terms.due for name, job in state.jobs.items()}
        return {name: due - self._moment.now_s for name, due in dues.items() if due is not None}

    def _ends(self, names: Sequence[str], ends_s: Mapping[str, float]) -> tuple[ExpectedJob, ...]:
        return tuple(
            ExpectedJob(name, ends_s[name] - self._moment.now_s if name in ends_s else None)
            for name in names
        )


class _Node:
    """The work of a node for others, and its own (semantics 7.5). Implements `ports.EventSink`."""

    def __init__(self, run: RunOn, handler: RequestHandler) -> None:
        self.run = run
        self.refusals: tuple[str, ...] = ()
        """Of requests, in their order."""
        self.not_anew: dict[str, str] = {}
        """Why a queued job could not be made anew."""
        self._handler = handler
        self._later: list[Callable[[], object]] = []
        for sink in (QueueAnew(handler, run.state, self._later.append), self):
            run.orchestrator.add_sink(sink)

    def publish(self, events: Sequence[e.Event]) -> None:
        """Note what the node refused itself."""
        refused = (event for event in events if isinstance(event, e.OperatorRefused))
        self.not_anew |= {
            refusal.job: refusal.message
            for refusal in refused
            if refusal.who == WHO and refusal.job
        }

    def hear(self, requests: Sequence[Asked]) -> None:
        """Carry out requests, and what the node does because of them."""
        self.refusals = tuple(
            '; '.join([f'{asked.request.name}: {answer.message}', *_findings(answer)])
            for asked in requests
            if not (answer := self.answer(asked)).accepted
        )

    def answer(self, asked: Asked) -> Answer:
        """Carry out one request, whoever makes it."""
        anybody = replace(asked.sender, role=Role.ENGINEER, known=Known.LOCAL_USER)
        answer = begin(self._handler.carry_out(replace(asked, by=anybody))).value
        while self._later:
            self._later.pop(0)()
        return answer


def _findings(answer: Answer) -> Iterator[str]:
    return (finding for order in answer.orders for finding in order.findings)


def _with_rests(
    rests: Mapping[str, str],
    before: Mapping[str, float | None],
    after: Mapping[str, float | None],
) -> Iterator[str]:
    """Say when all items of a job are made whose rest is queued anew."""
    for job, rest in rests.items():
        then, now = after.get(rest), before.get(job)
        if job in after and then is not None:
            whole = 'it is not known when' if now is None else f'{job} ends in {now:.1f} s'
            yield f'{job} with {rest} ends in {then:.1f} s; without the requeue, {whole}'


def _lost(run: RunOn) -> frozenset[str]:
    """Return the components that are out of service."""
    return frozenset(run.state.out_of_service)


def _unlooked(state: CellState, requests: Sequence[Asked]) -> Iterator[str]:
    """Say which ids cannot be looked up: the content of sealed parts stays with the node."""
    added = (asked.arguments for asked in requests if asked.request.takes_orders)
    given: Iterator[Any] = chain.from_iterable(
        cast('Any', arguments['orders']) for arguments in added
    )
    names = [order.order for order in given if order.order and order.order not in state.order_ids]
    if names and state.order_ids.sealed:
        ids = listed(names, '')
        yield f'whether {ids} was used before is not known here: the node alone has the oldest ids'


def _is_of_choice(field: str) -> bool:
    return field == 'version' or field.startswith('bind')


def _with_mistakes(wrong: Sequence[WrongField]) -> CheckedOrder:
    return CheckedOrder(False, counted(len(wrong), 'mistake'), tuple(wrong))
