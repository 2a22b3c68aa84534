"""The items of a job as files, all of them; the record of one item as a document."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from io import StringIO
from typing import NamedTuple
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.archive.archive import Archive, Look
from bt_orchestrator.extensions.page.web.archive.ended_jobs import job_record
from bt_orchestrator.extensions.page.web.archive.histories import reading
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Problem, attached
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord, job_to_plain
from bt_orchestrator.view.drawing.documents.html import Times
from bt_orchestrator.view.drawing.documents.item_page import Source, item_page
from bt_orchestrator.view.report.csv_export import write_items
from bt_orchestrator.view.report.item.reader import item_history

_REFUSALS = {
    404: 'nothing is known of the job',
    410: 'its items are not kept any more',
    503: 'the journal cannot be read now: the message says why',
}


class Kind(NamedTuple):
    """A kind of file."""

    ending: str
    media: str
    content: Callable[[JobRecord], str]


def _csv(job: JobRecord) -> str:
    file = StringIO(newline='')
    write_items(job, file)
    return file.getvalue()


def _json(job: JobRecord) -> str:
    return json_of(job_to_plain(job)) + '\n'


KINDS = (Kind('csv', 'text/csv', _csv), Kind('json', 'application/json', _json))


def endpoints(archive: Archive) -> tuple[Endpoint, ...]:
    """Return the endpoints."""
    return (*(_of_job(archive, kind) for kind in KINDS), _of_item(archive))


def _of_job(archive: Archive, kind: Kind) -> Endpoint:
    return Endpoint(
        'GET',
        f'/api/jobs/{{job}}/items.{kind.ending}',
        _answer(archive, kind),
        f'returns all items of a job as a {kind.ending.upper()} file',
        refusals=_REFUSALS,
        media=kind.media,
    )


def _of_item(archive: Archive) -> Endpoint:
    return Endpoint(
        'GET',
        '/api/items/{item:path}/record.html',
        _document(archive),
        'returns the whole record of an item as a document, for a browser and for paper',
        query={
            'zone': "its times are in this zone, as Europe/Berlin; else of the page's computer"
        },
        refusals={
            404: 'nothing is known of the item',
            503: 'the journal cannot be read now: the message says why',
        },
        media='text/html',
    )


def _document(archive: Archive) -> Callable[[Request], Awaitable[Response]]:
    def asked(look: Look, item: str, times: Times) -> str:
        history = item_history(reading(look), item)
        if history is None:
            raise Problem(404, f'nothing is known here of item {item}')
        begun = history.started is not None
        lacks = [archive.why_not_whole(look.extent, has_beginning=begun), *look.damage]
        journal = f'journal {look.extent.history}'.strip()
        source = Source(
            f'the {journal}', time.time(), [reason for reason in lacks if reason], times
        )
        return item_page([history], source, f'Item {item}')

    async def answer(request: Request) -> Response:
        name = request.path_params['item']
        times = _times(request.query_params.get('zone', ''))
        try:
            text = await archive.read(lambda look: asked(look, name, times))
        except JournalUnusable as error:
            raise Problem(503, str(error)) from error
        return Response(
            text.encode(), media_type='text/html', headers=attached(f'{_plain(name)}.html')
        )

    return answer


def _times(zone: str) -> Times:
    """Return how times are written; of a zone that this computer does not know, its own."""
    try:
        return Times(ZoneInfo(zone) if zone else None)
    except (ZoneInfoNotFoundError, ValueError, OSError):
        return Times()


def _plain(item: str) -> str:
    """Return an item's id as a part of a file name."""
    return item.replace('/', '-')


def _answer(archive: Archive, kind: Kind) -> Callable[[Request], Awaitable[Response]]:
    async def answer(request: Request) -> Response:
        name = request.path_params['job']
        try:
            text, is_whole = await archive.read(lambda look: _file(look, name, kind))
        except JournalUnusable as error:
            raise Problem(503, str(error)) from error
        # a file cannot say what it lacks in a way that every reader sees; its name can
        lacks = '' if is_whole else '-incomplete'
        headers = attached(f'{name}-items{lacks}.{kind.ending}')
        return Response(text.encode(), media_type=kind.media, headers=headers)

    return answer


def _file(look: Look, name: str, kind: Kind) -> tuple[str, bool]:
    """Return the text of a file, and whether everything is in it.

    :raises Problem: there is nothing to write
    """
    job = job_record(look, name)
    if job is None:
        raise Problem(404, f'nothing is known here of job {name}')
    if not job.complete:
        raise Problem(410, f'the items of job {name} are not kept any more: their events are gone')
    return kind.content(job), not look.damage
