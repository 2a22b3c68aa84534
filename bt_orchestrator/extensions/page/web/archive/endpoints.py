"""The routes of the past."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from itertools import islice
from typing import Any, NamedTuple, TypeVar

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.archive.archive import Archive, Look, each, event_of
from bt_orchestrator.extensions.page.web.archive.downloads import endpoints as of_downloads
from bt_orchestrator.extensions.page.web.archive.ended_jobs import MOST as MOST_JOBS
from bt_orchestrator.extensions.page.web.archive.ended_jobs import job_with_items, jobs_page
from bt_orchestrator.extensions.page.web.archive.histories import (
    Subject,
    history_of,
    item_record,
    items_of,
)
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem
from bt_orchestrator.extensions.page.web.seams import SeenCell
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.alarms import FOLLOWED, Alarm, AlarmFold, Kind, alarm_plain, often

MOST = 200
"""Most alarms of one answer."""

MOST_RECORDS = 20_000
"""Records that are looked through; a longer journal has older alarms."""


class Choice(NamedTuple):
    """The alarms that a reader wants; empty: all."""

    kind: str = ''
    component: str = ''
    is_open: bool = False

    def has(self, alarm: Alarm) -> bool:
        """Tell whether an alarm is wanted."""
        return (
            self.kind in ('', alarm.kind.value)
            and self.component in ('', alarm.component)
            and not (self.is_open and alarm.cleared_us is not None)
        )


def alarms_page(look: Look, choice: Choice) -> dict[str, Any]:
    """Return the last alarms, the last first, and which came most."""
    wanted = Wanted(events=FOLLOWED, newest_first=True)
    records = list(islice(each(look, wanted), MOST_RECORDS))
    fold = AlarmFold(SteadyTime())
    for record in reversed(records):
        event = event_of(record)
        if event is not None:
            fold.follow(event)
    alarms = [alarm for alarm in fold.alarms if choice.has(alarm)]
    return {
        'alarms': [_plain(alarm, fold.now_us) for alarm in reversed(alarms[-MOST:])],
        'counts': [
            {
                'kind': group.kind,
                'about': group.about,
                'reason': group.reason,
                'times': group.times,
            }
            for group in often(alarms, fold.now_us)
        ],
        'is_cut': len(alarms) > MOST or len(records) == MOST_RECORDS,
        'damage': look.damage,
        'has_beginning': len(records) == MOST_RECORDS,
    }


def _plain(alarm: Alarm, now_us: int) -> dict[str, Any]:
    held = alarm.held
    message = alarm.words if held is None else held.message
    return {
        **alarm_plain(alarm, now_us),
        'said': said_in_each(message),
        'controller_said': '' if held is None else held.controller_said,
    }


_Found = TypeVar('_Found', dict[str, Any], dict[str, Any] | None)

MOST_KINDS = 100
"""Each record of a page is compared with all of them."""

EVENTS_USUAL = 200
"""Records of an answer unless another number is asked for."""

_UNREAD = {503: 'the journal cannot be read now: the message says why'}
_UNKNOWN = {404: 'nothing is known of it', **_UNREAD}


def endpoints(archive: Archive, cell: SeenCell) -> tuple[Endpoint, ...]:
    """Return the endpoints."""
    routes = _Routes(archive, cell)
    return (
        *of_downloads(archive),
        Endpoint(
            'GET',
            '/api/events',
            routes.events,
            'returns records of events, newest first, or from one on',
            query={
                'after': 'number of an event: those after it, oldest first',
                'before': 'number of an event: those before it, newest first',
                'most': f'so many at most, up to {MOST_EVENTS}; absent: {EVENTS_USUAL}',
                'kinds': 'names of events with commas, * as wildcard; `task.`: all of tasks',
                'job': 'of this job only',
            },
            refusals=_UNREAD,
        ),
        Endpoint(
            'GET',
            '/api/alarms',
            routes.alarms,
            f'returns the last alarms, at most {MOST}, newest first, and which came most',
            query={
                'kind': f'{", ".join(kind.value for kind in Kind)}; absent: all',
                'component': 'of this component only',
                'open': '1: only those that stand',
            },
            refusals=_UNREAD,
        ),
        Endpoint(
            'GET',
            '/api/jobs',
            routes.jobs,
            'returns jobs, newest first',
            query={
                'after': '`rest` of the answer before; absent: from the newest',
                'most': f'so many at most, up to {MOST_JOBS}',
            },
            refusals=_UNREAD,
        ),
        Endpoint(
            'GET',
            '/api/jobs/{job}',
            routes.job,
            'returns a job with its items and failures',
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'GET',
            '/api/serials/{serial:path}',
            routes.serial,
            'returns the items of a serial, newest first, as far as their events are kept',
            refusals=_UNREAD,
        ),
        Endpoint(
            'GET',
            '/api/items/{item:path}',
            routes.item,
            'returns everything about an item: attempts, results, decisions',
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'GET',
            '/api/sections/{section:int}/history',
            routes.section,
            'returns the last cycles of a section, its failures and times',
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'GET',
            '/api/components/{component}/history',
            routes.component,
            'returns the last work of a component, its failures and times',
            refusals=_UNKNOWN,
        ),
    )


class _Routes:
    def __init__(self, archive: Archive, cell: SeenCell) -> None:
        self._archive = archive
        self._cell = cell

    async def events(self, request: Request) -> Response:
        query = request.query_params
        after, before = _whole(query, 'after'), _whole(query, 'before')
        kinds = tuple(filter(None, query.get('kinds', '').split(',')))
        if len(kinds) > MOST_KINDS:
            raise Problem(422, f'kinds are at most {MOST_KINDS} names; found {len(kinds)}')
        wanted = Wanted(
            after_seq=after or 0,
            before_seq=before,
            job=query.get('job') or None,
            events=kinds,
            newest_first=after is None,
        )
        most = _whole(query, 'most') or EVENTS_USUAL
        return Json(await self._read(lambda look: events_page(look, wanted, most)))

    async def alarms(self, request: Request) -> Response:
        query = request.query_params
        kind = query.get('kind', '')
        if kind and kind not in (kinds := [member.value for member in Kind]):
            raise Problem(422, f'kind is one of {", ".join(kinds)}; found {kind!r}')
        choice = Choice(kind, query.get('component', ''), query.get('open') == '1')
        return Json(await self._read(lambda look: alarms_page(look, choice)))

    async def jobs(self, request: Request) -> Response:
        query = request.query_params
        most = _whole(query, 'most') or MOST_JOBS
        try:
            page = await self._read(lambda look: jobs_page(look, query.get('after', ''), most))
        except ValueError as error:
            raise Problem(422, 'after is what an answer named as rest') from error
        return Json(page)

    async def job(self, request: Request) -> Response:
        job = request.path_params['job']
        answer = await self._read(lambda look: job_with_items(look, job))
        return _known(answer, f'job {job}')

    async def item(self, request: Request) -> Response:
        item = request.path_params['item']
        return _known(await self._read(lambda look: item_record(look, item)), f'item {item}')

    async def serial(self, request: Request) -> Response:
        serial = request.path_params['serial']
        return Json(await self._read(lambda look: items_of(look, serial)))

    async def section(self, request: Request) -> Response:
        number = request.path_params['section']
        described = self._cell.description
        if described is not None and not 1 <= number <= described.sections:
            raise Problem(404, f'sections are 1 to {described.sections}; found {number}')
        return await self._history(Subject(section=number))

    async def component(self, request: Request) -> Response:
        name = request.path_params['component']
        described = self._cell.description
        names = [component.name for component in described.components] if described else [name]
        if name not in names:
            raise Problem(404, f'there is no component {name}; one of {", ".join(names)}')
        return await self._history(Subject(component=name))

    async def _history(self, subject: Subject) -> Response:
        status, described = self._cell.status, self._cell.description
        now = status.stamp if status is not None else 0.0
        return Json(await self._read(lambda look: history_of(look, subject, now, described)))

    async def _read(self, question: Callable[[Look], _Found]) -> _Found:
        """Read, and say how much of the past there is."""
        archive = self._archive

        def asked(look: Look) -> _Found:
            answer = question(look)
            if answer is not None:
                begins = answer.pop('has_beginning', False)
                lacks = archive.why_not_whole(look.extent, has_beginning=begins)
                why = [answer.get('why_not', ''), lacks, *look.damage]
                reason = '; '.join(dict.fromkeys(filter(None, why)))
                answer.update(is_whole=not reason, why_not=reason)
            return answer

        try:
            return await archive.read(asked)
        except JournalUnusable as error:
            raise Problem(503, str(error)) from error


def _known(answer: dict[str, Any] | None, what: str) -> Response:
    if answer is None:
        raise Problem(404, f'nothing is known here of {what}')
    return Json(answer)


def _whole(query: Mapping[str, str], name: str) -> int | None:
    """Return a number of the query; None: it is not there.

    :raises Problem: it is none
    """
    text = query.get(name)
    if not text:
        return None
    if not (text.isascii() and text.isdecimal() and len(text) < 16):
        raise Problem(422, f'{name} is a whole number; found {text!r}')
    return int(text)


# Events by pages, as records.

MOST_EVENTS = 1000
"""Most records of one answer."""


def events_page(look: Look, wanted: Wanted, most: int) -> dict[str, Any]:
    """Return the next wanted records, and where to go on."""
    page = look.records.page(wanted, min(most, MOST_EVENTS))
    look.note(list(page.damage))
    rest = page.rest
    cursor = {'before': rest.before_seq} if wanted.newest_first else {'after': rest.after_seq}
    return {
        'history': page.history,
        'first_seq': look.extent.first_seq,
        'last_seq': look.extent.last_seq,
        'records': [json.loads(record.text) for record in page.records],
        'rest': None if page.is_last else cursor,
        'damage': look.damage,
    }
