"""Work orders that were read: commands to the engine, and what is said of each order."""

from __future__ import annotations

import itertools
import pickle
from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from bt_orchestrator.base.errors import CommandRefused, NotRead, Refused, counted
from bt_orchestrator.engine.runtime.deciding import not_from_there
from bt_orchestrator.engine.runtime.job_queue import AT_PANEL, standing
from bt_orchestrator.engine.runtime.permits.surroundings import refuse_unsafe
from bt_orchestrator.model.by import Control
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer, OrderAnswer, RefusedRequest
from bt_orchestrator.model.jobs.order import Job, RecipeChoice, WorkOrder
from bt_orchestrator.model.limits import FINDINGS, ORDERS, REQUEST_BYTES, listed
from bt_orchestrator.model.requests import Asked, refusal
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import joined, sentence
from bt_orchestrator.ports import ActionTypes, MadeScript
from bt_orchestrator.script.orders.asked import asked_of
from bt_orchestrator.script.orders.desk import (
    AskedOrder,
    ChangedJob,
    OrderDesk,
    Orders,
    Question,
    Reading,
    Wanted,
)

PREFIX = 'WO-'
"""Prefix of the ids that are assigned to orders without one."""

_AS_ORDERED = RecipeChoice(())
"""Names nothing of a recipe: all of it stays."""

ALL = 'bt-orchestrator check --json, where the files are, lists all'


# --- before they are read -----------------------------------------------------------------------


def check_sender(asked: Asked) -> None:
    """Refuse before reading: do not read orders of a request that will be refused.

    :raises NotRead: says why
    """
    why = refusal(asked.request, asked.sender)
    if why is not None:
        raise NotRead(why)


def check_place(asked: Asked, state: CellState) -> None:
    """Refuse before anything is read what cannot come from there, or not now (7.8, 7.9).

    :raises CommandRefused: says from where it can come, or what it waits for
    """
    if refusal(asked.request, asked.sender, asked.arguments) is None:  # that comes first
        why = not_from_there(state, asked)
        if why is not None:
            raise CommandRefused(why)
        refuse_unsafe(state, asked)


def wanted_orders(given: Sequence[AskedOrder | WorkOrder | Mapping[str, Any]]) -> Orders:
    """Return what is to be read.

    :param given: or mappings with the keys of an order file
    :raises NotRead: they are none, too many, or too large
    :raises CommandRefused: one is no order
    """
    if not given:
        raise NotRead(sentence('no_orders'))
    if len(given) > ORDERS:
        raise NotRead(sentence('many_orders', count=len(given), most=ORDERS))
    orders = tuple(map(asked_of, given))
    size = sum(map(_size, orders))
    if size > REQUEST_BYTES:
        raise NotRead(sentence('large_orders', count=size, most=REQUEST_BYTES))
    return Orders(orders)


def changed_job(state: CellState, name: str, wish: AskedOrder) -> ChangedJob:
    """Return the order for a new version of a queued job, in its present state.

    :raises NotRead: it is not there
    """
    now = state.jobs.get(name)
    if now is None:
        there = listed(state.jobs.queued_names, 'nothing')
        raise NotRead(sentence('not_queued', job=name, jobs=there))
    job = now.job
    return ChangedJob(name, now.digest, job.quantity, job.params, wish, job.terms, job.recipe)


def job_anew(state: CellState, name: str) -> ChangedJob:
    """Return a queued job in its present state, with its script to be generated again.

    :raises NotRead: it is not there, or was not ordered by recipe
    """
    anew = changed_job(state, name, AskedOrder(recipe=_AS_ORDERED))
    if anew.recipe is None:
        raise NotRead(sentence('not_by_recipe', job=name))
    return anew


def free_ids(wanted: Wanted, state: CellState) -> tuple[str, ...]:
    """Return ids for orders without one."""
    named = tuple(wanted.named)
    nameless, taken = named.count(''), frozenset(named)
    free = (name for name in state.order_ids.free(PREFIX) if name not in taken)
    return tuple(itertools.islice(free, nameless))


def size_of(text: str) -> int:
    """Return how many bytes a text has."""
    return len(text) if text.isascii() else len(text.encode(errors='replace'))


def _size(order: AskedOrder) -> int:
    params, details, recipe = order.params, order.terms.details, order.recipe
    texts = [order.text, order.script, order.order, details, *params, *params.values()]
    if recipe is not None:
        texts += [*recipe.recipes, *recipe.bind, *recipe.bind.values()]
    return sum(map(size_of, texts))


# --- after that ---------------------------------------------------------------------------------


def refused_orders(asked: Asked, orders: Orders, read: Sequence[Job | Refused]) -> RefusedRequest:
    """Return what is put on record of orders that were read, some of them with mistakes."""
    pairs = list(zip(orders.orders, read, strict=True))
    each = tuple(
        sentence('fits', job=result.id)
        if isinstance(result, Job)
        else f'{_name(order)} is {result.in_short}'
        for order, result in pairs
    )
    ids = tuple(result.id if isinstance(result, Job) else order.order for order, result in pairs)
    return RefusedRequest(asked.request.word, asked.sender, joined(*each), ids, each)


def answer_to_refused(orders: Orders, read: Sequence[Job | Refused]) -> Answer:
    """Return the answer to the sender of the orders."""
    findings = sum(len(result.findings) for result in read if isinstance(result, Refused))
    message = f'refused with {counted(findings, "finding")}'
    return Answer(
        accepted=False, message=message, orders=tuple(_each_refused(orders.orders, read))
    )


def _each_refused(
    orders: Iterable[AskedOrder], read: Iterable[Job | Refused]
) -> Iterator[OrderAnswer]:
    mistakes = Told()
    for order, result in zip(orders, read, strict=True):
        if isinstance(result, Job):
            yield OrderAnswer(message=sentence('fits', job=result.id))
        else:
            yield OrderAnswer(
                message=f'{_name(order)} is {result.count}', findings=mistakes.of(result)
            )


def with_each(answer: Answer, jobs: Sequence[Job], state: CellState) -> Answer:
    """Return the engine's answer about jobs, with what is said of each."""
    if answer.accepted:
        orders = [OrderAnswer(job.id, '; '.join(_queued(job, state))) for job in jobs]
    else:
        each = answer.each or (answer.message,) * len(jobs)
        orders = [OrderAnswer(message=message) for message in each]
    return Answer(answer.accepted, answer.message, answer.each, tuple(orders))


def _queued(job: Job, state: CellState) -> Iterator[str]:
    yield sentence('queued')
    live = state.jobs.get(job.id)
    if live is not None and live.held and state.control is Control.LOCAL:
        yield AT_PANEL
    yield from standing(state)


def _name(order: AskedOrder) -> str:
    """Return the words by which a client knows its order."""
    recipe = order.recipe.words if order.recipe else ''
    return order.order or order.script or recipe or 'the order'


class Told:
    """Findings for one answer: not more than it may have."""

    def __init__(self) -> None:
        self._left = FINDINGS
        self._said_that_more = False

    def of(self, refused: Refused) -> tuple[str, ...]:
        """Return the mistakes of one order."""
        findings = refused.findings[: self._left]
        self._left -= len(findings)
        more = len(refused.findings) - len(findings)
        rest = [f'and {more} more; {ALL}'] if more and not self._said_that_more else []
        self._said_that_more |= more > 0
        return (*map(str, findings), *rest)


# Reads orders in this process, for an engine that need not meet deadlines.


class DeskHere:
    """Makes jobs of orders at once. Implements `handler.OrderReading`."""

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        trees: Sequence[Path],
        state: CellState,
        *,
        any_path: bool = True,
    ) -> None:
        """Read scripts, by name in some folders or by path.

        :param state: of the engine that the orders are for
        :param any_path: also scripts outside the folders
        """
        self._desk = OrderDesk(cell, types, trees, any_path=any_path)
        self._state = state

    @asynccontextmanager
    async def read(self, wanted: Wanted | Callable[[], Wanted]) -> AsyncIterator[Reading]:
        """Read them now.

        :raises NotRead: says why nothing was read
        """
        yield self.reading(wanted() if callable(wanted) else wanted)

    def script(self, name: str) -> Script | Refused:
        """Read a script."""
        return self._desk.script(name)

    def made(self, made: MadeScript) -> Script | Refused:
        """Read a script that was generated."""
        return self._desk.made(made)

    def reading(self, wanted: Wanted) -> Reading:
        """Return what becomes of orders in the state of now."""
        scripts = self._state.scripts
        live = tuple(name for name, script in scripts.items() if script.dependencies)
        sent = {name: pickle.dumps(script) for name, script in scripts.items()}
        ids = free_ids(wanted, self._state)
        return self._desk.answer(Question(wanted, ids, live, sent))
