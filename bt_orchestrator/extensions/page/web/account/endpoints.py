"""The endpoints of the shift that runs: its account, and its figures as metrics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from typing import NamedTuple, Protocol

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.account.watch import ShiftWatch
from bt_orchestrator.extensions.page.web.endpoint import (
    Endpoint,
    Json,
    Problem,
    attached,
    language_of,
)
from bt_orchestrator.extensions.page.web.seams import SeenCell
from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports.doors.doors import Doors
from bt_orchestrator.view.drawing.account.beside_page import beside_page
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.drawing.wording import Wording
from bt_orchestrator.view.report.account.account import NothingToReport
from bt_orchestrator.view.report.account.live import Live, live_plain
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.named_figures import By
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.beside import Beside, Column
from bt_orchestrator.view.report.beside_words import beside_plain

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
_OF_DOCUMENTS = {**_REFUSALS, 422: 'there are no words in this language'}


_LANGUAGE = {'language': f'of its words: {", ".join(wordings())}'}


class _Cell(SeenCell, Protocol):
    doors: Doors


def endpoints(watch: ShiftWatch, cell: _Cell) -> tuple[Endpoint, ...]:
    """Return the endpoints."""

    async def shift(_: Request) -> Response:
        return Json(live_plain(_live(watch)))

    async def report(request: Request) -> Response:
        account = _live(watch).account
        name = f'{account.period.name.replace(" ", "-")}.html'
        text = account_page(account, _words(request))
        return Response(text.encode(), media_type='text/html', headers=attached(name))

    async def by(request: Request) -> Response:
        owners, account = _by(request.path_params['by']), _live(watch).account
        column = Column(account.period.name, account.period, account)
        return Json(beside_plain(Beside((column,), account), owners))

    async def days(request: Request) -> Response:
        _refuse_without_shifts(watch)
        owners = request.query_params.get('by')
        wanted = _by(owners) if owners else None
        try:
            report = await watch.days(DAYS)
        except (NothingToReport, JournalUnusable) as error:
            raise Problem(503, f'there is no account of the last days now: {error}') from error
        name = f'{report.together.period.name.replace(" ", "-")}.html'
        text = beside_page(report, wanted, _words(request))
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
            query=_LANGUAGE,
            refusals=_OF_DOCUMENTS,
            media='text/html',
        ),
        Endpoint(
            'GET',
            '/api/shift/by/{by}',
            by,
            'returns the same by product, job or component, as `report --by --json` prints it',
            refusals={**_REFUSALS, 400: 'by has to be product, job or component'},
        ),
        Endpoint(
            'GET',
            '/api/shift/days.html',
            days,
            f'returns the last {DAYS} days side by side, as `report --days {DAYS} --html` does',
            query={
                'by': 'product, job or component: one of these in place of the line',
                **_LANGUAGE,
            },
            refusals={**_OF_DOCUMENTS, 400: 'by has to be product, job or component'},
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


def _words(request: Request) -> Wording:
    return wordings()[language_of(request, wordings(), 'en')]


def _by(word: str) -> By:
    """Return what the rows are of.

    :raises Problem: there is no such thing
    """
    try:
        return By(word)
    except ValueError as error:
        raise Problem(400, f'expected product, job or component, found {word!r}') from error


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


# The state of a cell and the figures of its shift, as OpenMetrics and Prometheus read them.

Labels = Mapping[str, str]
Value = Fraction | float | int


class Gauge(NamedTuple):
    """A metric with its samples; all are gauges: what a shift counts begins anew with the next."""

    name: str
    """Without the prefix that all have."""
    meaning: str
    samples: Iterable[tuple[Labels, Value | None]]
    """None: not known; left out."""

    def lines(self) -> Iterator[str]:
        """Yield its lines."""
        name = f'bt_orchestrator_{self.name}'
        yield f'# HELP {name} {self.meaning}'
        yield f'# TYPE {name} gauge'
        for labels, value in self.samples:
            if value is not None:
                yield f'{name}{{{_written(labels)}}} {_number(value)}'


def metrics(node: str, silent_s: float, status: CellStatus | None, live: Live | None) -> str:
    """Return all that is known; the text is both OpenMetrics and the older form of Prometheus."""
    gauges = [Gauge('node_silent_seconds', 'Time since the node was heard.', [
        ({'node': node}, silent_s)
    ])]  # fmt: skip
    if status is not None:
        gauges += _of_cell(status)
    if live is not None and live.now.turn is not None:
        gauges += _of_shift(live, status.cell if status else live.account.figures.times.cell)
    return ''.join(f'{line}\n' for gauge in gauges for line in (*gauge.lines(),)) + '# EOF\n'


def _of_cell(status: CellStatus) -> Iterator[Gauge]:
    cell = {'cell': status.cell}
    states = [
        ({**cell, 'state': state.value}, int(state is status.state)) for state in PackmlState
    ]
    yield Gauge('cell_state', 'PackML state of the cell: 1 for the one it is in.', states)
    yield Gauge('holds', 'Holds that wait for an answer.', [(cell, len(status.holds))])
    yield Gauge('jobs_queued', 'Jobs that wait in the queue.', [(cell, status.queued)])


def _of_shift(live: Live, cell: str) -> Iterator[Gauge]:
    assert live.now.turn is not None
    of = {'cell': cell, 'shift': live.now.turn.shift}
    shown, period = live.account.figures, live.now.period
    begin, times = period.shown_us(period.begin_us), shown.times

    def gauge(name: str, meaning: str, value: Value | None) -> Gauge:
        return Gauge(f'shift_{name}', meaning, [(of, value)])

    yield gauge('runs', '1: the shift runs; 0: it is the last one that ended.', int(live.runs))
    yield gauge('begin_timestamp_seconds', 'When the shift began.', Fraction(begin, US))
    yield gauge('oee_ratio', 'Overall equipment effectiveness.', shown.oee)
    yield gauge('availability_ratio', 'Production time of planned busy time.', shown.availability)
    yield gauge(
        'performance_ratio', 'Output as a part of the output at the pace.', shown.performance
    )
    yield gauge('quality_ratio', 'Good items of produced ones.', shown.quality)
    yield gauge('planned_seconds', 'Planned time so far.', Fraction(times.planned.total_us, US))
    yield gauge('busy_seconds', 'Planned busy time so far.', Fraction(times.busy_us, US))
    yield gauge('production_seconds', 'Production time so far.', Fraction(times.production_us, US))
    lost = [({**of, 'loss': loss.value}, shown.loss_us(loss) / US) for loss in _known(live)]
    yield Gauge(
        'shift_lost_seconds', 'Time lost so far; below 0: the line was faster than its pace.', lost
    )
    made = {
        kind: sum(getattr(job, kind) for job in times.made)
        for kind in ('good', 'nonconforming', 'rejected', 'by_hand')
    }
    items = [({**of, 'outcome': kind}, number) for kind, number in made.items()]
    yield Gauge('shift_items', 'Items that left the line in planned time.', items)


def _known(live: Live) -> Iterator[Loss]:
    """Yield the losses that are known: some need a pace."""
    needs_pace = (Loss.REWORK, Loss.SLOW, Loss.REJECTS)
    for loss in Loss:
        if live.account.figures.has_paces or loss not in needs_pace:
            yield loss


def _written(labels: Labels) -> str:
    return ','.join(f'{name}="{_escaped(value)}"' for name, value in labels.items())


def _escaped(text: str) -> str:
    text = text.replace('\\', '\\\\').replace('"', '\\"').replace('\n', '\\n')
    return text.encode(errors='replace').decode()


def _number(value: Value) -> str:
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: '+Inf', -math.inf: '-Inf'}.get(value, 'NaN')
    return f'{value}' if isinstance(value, int) else repr(round(float(value), 6))
