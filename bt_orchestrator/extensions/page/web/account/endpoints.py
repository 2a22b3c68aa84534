"""The endpoints of the shift that runs."""

from __future__ import annotations

from typing import Protocol

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.account.metrics import metrics
from bt_orchestrator.extensions.page.web.account.watch import ShiftWatch
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.extensions.page.web.replies import Json, Problem, attached
from bt_orchestrator.extensions.page.web.seams import SeenCell
from bt_orchestrator.ports.doors.doors import Doors
from bt_orchestrator.view.drawing.account.beside_page import beside_page
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.report.account.account import NothingToReport
from bt_orchestrator.view.report.account.live import Live
from bt_orchestrator.view.report.account.live_words import live_plain

DAYS = 7
"""Of the document that shows days side by side: a week."""

OPEN_METRICS = 'application/openmetrics-text'
_TEXTS = {
    True: f'{OPEN_METRICS}; version=1.0.0; charset=utf-8',
    False: 'text/plain; version=0.0.4; charset=utf-8',
}

_REFUSALS = {
    404: 'the page knows no shifts: it was started without --shifts',
    503: 'there is no account now: the message says why',
}


class _Cell(SeenCell, Protocol):
    doors: Doors


def endpoints(watch: ShiftWatch, cell: _Cell) -> tuple[Endpoint, ...]:
    """Return the endpoints."""

    async def shift(_: Request) -> Response:
        return Json(live_plain(_live(watch)))

    async def report(_: Request) -> Response:
        account = _live(watch).account
        name = f'{account.period.name.replace(" ", "-")}.html'
        text = account_page(account)
        return Response(text.encode(), media_type='text/html', headers=attached(name))

    async def days(_: Request) -> Response:
        _refuse_without_shifts(watch)
        try:
            report = await watch.days(DAYS)
        except (NothingToReport, JournalUnusable) as error:
            raise Problem(503, f'there is no account of the last days now: {error}') from error
        name = f'{report.together.period.name.replace(" ", "-")}.html'
        text = beside_page(report, None)
        return Response(text.encode(), media_type='text/html', headers=attached(name))

    async def measured(request: Request) -> Response:
        text = metrics(cell.doors.name, cell.doors.silent_s, cell.status, watch.live)
        media = _TEXTS[OPEN_METRICS in request.headers.get('accept', '')]
        headers = {'content-type': media, 'cache-control': 'no-store'}
        return Response(text.encode(), headers=headers)

    return (
        Endpoint(
            'GET',
            '/api/shift',
            shift,
            'returns the account of the shift that runs, as `report --follow --json` prints it',
            refusals=_REFUSALS,
        ),
        Endpoint(
            'GET',
            '/api/shift/report.html',
            report,
            'returns the same as a document, for a browser and for paper',
            refusals=_REFUSALS,
            media='text/html',
        ),
        Endpoint(
            'GET',
            '/api/shift/days.html',
            days,
            f'returns the last {DAYS} days side by side, as `report --days {DAYS} --html` does',
            refusals=_REFUSALS,
            media='text/html',
        ),
        Endpoint(
            'GET',
            '/metrics',
            measured,
            'returns the state of the cell and the figures of the shift that runs, for Prometheus',
            media='text/plain',
        ),
    )


def _live(watch: ShiftWatch) -> Live:
    """Return the account.

    :raises Problem: there is none
    """
    _refuse_without_shifts(watch)
    if watch.live is None:
        raise Problem(503, f'there is no account of the shift now: {watch.why_not}')
    return watch.live


def _refuse_without_shifts(watch: ShiftWatch) -> None:
    if not watch.is_wanted:
        raise Problem(404, 'the page knows no shifts; start it with --shifts FILE')
