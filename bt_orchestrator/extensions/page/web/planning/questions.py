"""Questions to the planning process, one at a time, without keeping the server's loop."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

from bt_orchestrator.base.errors import NotKept, Refused
from bt_orchestrator.extensions.page.web.offers import arrange_offer
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.by import By
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.requests import Asked, ask, of_name
from bt_orchestrator.ports import (
    CheckedOrder,
    ExpectedJob,
    JobChange,
    Moment,
    Planning,
    ProposedJob,
)
from bt_orchestrator.script.orders.plain_order import order_from

MOST_WAITING = 8
"""Questions at a time; a browser that goes on asking withdraws the ones before."""

Body = dict[str, object]

IsGone = Callable[[], Awaitable[bool]]
"""Tells whether the question was withdrawn."""


class TooManyQuestions(Exception):
    """So many are being worked out that another one would have to wait for long."""


class Withdrawn(Exception):
    """The question was withdrawn before its turn came."""


class Questions:
    """Asks what would be, from the state of now. All calls come from the loop's thread."""

    def __init__(self, planning: Planning | None, moment: Callable[[], Awaitable[Moment]]) -> None:
        """Prepare; nothing is started before the first question.

        :param planning: None: every question is refused
        """
        self._planning = planning
        self._moment = moment
        self._turn = asyncio.Lock()
        self._waiting = 0

    async def what_if(self, requests: Sequence[Asked], queued: int, is_gone: IsGone) -> Body:
        """Return when jobs end without and with some requests, as seconds since the epoch.

        :param queued: length of the queue
        :raises NodeUnreachable: it does not tell its state
        :raises NotKept: nothing could be worked out
        """
        began = time.monotonic()

        def work(planning: Planning, moment: Moment) -> Body:
            consequence = planning.what_if(moment, requests)
            return {
                'before': _ends(consequence.before, moment),
                'after': _ends(consequence.after, moment),
                'jobs': [_changed(change, moment.now_s) for change in consequence.changes],
                'refusals': list(consequence.refusals),
                'refusals_said': [
                    said_in_each(words.partition(': ')[2]) for words in consequence.refusals
                ],
                'unknown': _said(consequence.unknown),
                'notes': list(consequence.notes),
                'left_out': max(0, queued - QUEUE_SHOWN),
                'computed_s': round(time.monotonic() - began, 1),
            }

        return await self._ask(work, is_gone)

    async def propose(self, queued: int, is_gone: IsGone) -> Body:
        """Return an order for the queue, with the offer that applies it; ends as in `what_if`.

        :param queued: length of the queue
        :raises NodeUnreachable: it does not tell its state
        :raises NotKept: nothing could be worked out
        """

        def work(planning: Planning, moment: Moment) -> Body:
            proposal = planning.propose(moment)
            offer = (
                arrange_offer(proposal.order, proposal.queue_digest) if proposal.is_new else None
            )
            return {
                **proposal._asdict(),
                'jobs': [_proposed(job, moment.now_s) for job in proposal.jobs],
                'unknown': _said(proposal.unknown),
                'offer': offer,
                'left_out': max(0, queued - QUEUE_SHOWN),
            }

        return await self._ask(work, is_gone)

    async def check(self, order: Mapping[str, object], is_gone: IsGone) -> Body:
        """Return what would be said of an order.

        :raises NodeUnreachable: the node does not tell its state
        :raises NotKept: nothing could be worked out
        """

        def work(planning: Planning, moment: Moment) -> Body:
            return _plain(planning.check(moment, order))

        return await self._ask(work, is_gone)

    def close(self) -> None:
        """End the work on it; its reader gets the reason."""
        if self._planning is not None:
            self._planning.close()

    async def _ask(self, work: Callable[[Planning, Moment], Body], is_gone: IsGone) -> Body:
        planning = self._planning
        if planning is None:
            raise NotKept('this page works nothing out')
        if self._waiting >= MOST_WAITING:
            raise TooManyQuestions('several questions are being worked out; ask again')
        self._waiting += 1
        try:
            async with self._turn:
                if await is_gone():
                    raise Withdrawn('the question was withdrawn')
                moment = await self._moment()
                return await asyncio.to_thread(work, planning, moment)
        finally:
            self._waiting -= 1


def asked_of(command: object) -> Asked:
    """Return a request from JSON: {name, arguments}.

    :raises ValueError: it is none; the message says what was expected
    """
    if not isinstance(command, Mapping) or not isinstance(command.get('name'), str):
        raise ValueError('a command is an object with the name of a request and its arguments')
    given: Any = command.get('arguments') or {}
    if not isinstance(given, Mapping):
        raise ValueError('the arguments of a command are an object')
    arguments = dict(given)
    request = of_name(command['name'])
    if request is not None and request.takes_orders:
        arguments['orders'] = _orders(arguments.get('orders'))
    if not all(isinstance(key, str) and key not in _OWN for key in arguments):
        raise ValueError(f'{command["name"]} does not take {", ".join(arguments)}')
    return ask(command['name'], By('', 'page', 'what if'), **arguments)


_OWN = frozenset(('name', 'by'))
"""Names of what `ask` itself takes."""


def _orders(plain: object) -> object:
    if not isinstance(plain, list) or not all(isinstance(order, Mapping) for order in plain):
        raise ValueError('orders are a list of objects with the keys of an order file')
    try:
        return [order_from(order) for order in plain]
    except Refused as refused:
        raise ValueError('; '.join(map(str, refused.findings))) from refused


def _said(reasons: Mapping[str, str]) -> dict[str, dict[str, str]]:
    return {job: said_in_each(why) for job, why in reasons.items()}


def _ends(jobs: Sequence[ExpectedJob], moment: Moment) -> list[Body]:
    return [{'job': job.job, 'ends': _time(job.ends_s, moment.now_s)} for job in jobs]


def _changed(job: JobChange, now_s: float) -> Body:
    """Return what becomes of a job; `before` and `after` stand where it is there."""
    here = {'before': job.before, 'after': job.after}
    ends = {name: _time(end.ends_s, now_s) for name, end in here.items() if end is not None}
    return {
        'job': job.job,
        'change': job.change,
        **ends,
        'by_s': job.by_s,
        'due': None if job.due_s is None else now_s + job.due_s,
        'is_late': job.is_late(job.after),
        'was_late': job.is_late(job.before),
    }


def _time(from_now_s: float | None, now_s: float) -> float | None:
    return None if from_now_s is None else now_s + from_now_s


def _proposed(job: ProposedJob, now_s: float) -> Body:
    ends, new_ends = _time(job.ends_s, now_s), _time(job.new_ends_s, now_s)
    plain = {name: value for name, value in job._asdict().items() if not name.endswith('_s')}
    return {**plain, 'ends': ends, 'new_ends': new_ends}


def _plain(checked_order: CheckedOrder) -> Body:
    return {
        'accepted': checked_order.accepted,
        'is_checked': checked_order.is_checked,
        'message': checked_order.message,
        'said': said_in_each(checked_order.message),
        'findings': [
            {
                **mistake._asdict(),
                'said': said_in_each('; '.join(filter(None, (mistake.what, mistake.hint)))),
            }
            for mistake in checked_order.wrong
        ],
    }
