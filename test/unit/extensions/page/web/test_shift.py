"""The account of the shift that runs: the part of the page, its document, and the metrics."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from datetime import date
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import LINE, SHIFTS, the_day
from fakes.page_bench import PeopleBench
from fakes.statuses import status

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.account import ShiftWatch, endpoints, watch
from bt_orchestrator.extensions.page.web.archive.archive import Archive
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.extensions.page.web.seams import Plant
from bt_orchestrator.model.events import ClockStepped
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import Records
from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.drawing.account.beside_page import beside_page
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.report.account.account import account
from bt_orchestrator.view.report.account.calendar import day_columns, shift_at
from bt_orchestrator.view.report.account.live import LiveAccount, live_plain
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.named_figures import By
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.beside import Beside, Column, beside
from bt_orchestrator.view.report.beside_words import beside_plain
from bt_orchestrator.view.report.reading import Reading

NOTHING = {'shift': None, 'is_reading': False}

PLANT = Plant(parse_shifts(SHIFTS, 'shifts.yaml'), LINE.cell)


def journal(clock: str) -> MemoryRecords:
    store = MemoryStore('day')
    store.append([event for event in the_day().events if event.time <= at(clock)])
    return MemoryRecords(store)


class ShiftBench(PeopleBench):
    """A page with people and a shift; what time it is, is set."""

    def __init__(self, folder: Path, plant: Plant | None = PLANT, **options: Any) -> None:
        self.journal: Callable[[], Records] = partial(journal, '12:05')
        archive = Archive(cast('Any', None), self._opened, lambda: 'day')
        self.told = 0
        self.watch = ShiftWatch(plant, archive, self._tell)
        self.doors = SimpleNamespace(name='/n', silent_s=0.25)
        self.status: CellStatus | None = None
        super().__init__(folder, **options)

    def endpoints(self) -> list[Endpoint]:
        return [*super().endpoints(), *endpoints(self.watch, cast('Any', self))]

    def look(self) -> dict[str, Any]:
        """Look once; return the part of the page."""
        self.loop.run_until_complete(self.watch.look())
        return cast('dict[str, Any]', self.watch.parts()['shift'])

    def close(self) -> None:
        self.watch.close()
        super().close()

    def _opened(self) -> Records:
        return self.journal()

    def _tell(self) -> None:
        self.told += 1


Start = Callable[..., ShiftBench]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Give a function that starts a page."""
    with ExitStack() as stack:
        yield lambda *args, **more: stack.enter_context(
            closing(ShiftBench(tmp_path, *args, **more))
        )


@pytest.fixture
def bench(start: Start, clock: Callable[[str], None]) -> ShiftBench:
    """A page at 12:05 of the hand-made shift."""
    clock('12:05')
    return start()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Give a function that sets the clock of the page."""
    return lambda text: monkeypatch.setattr(watch, 'time', SimpleNamespace(time=lambda: at(text)))


def report(clock: str, records: Records) -> dict[str, Any]:
    """Return what a report says that is made later, of the shift until then."""
    live = LiveAccount(partial(shift_at, PLANT.shifts), None).look(records, at(clock))
    assert live is not None
    return account_plain(account(Reading(journal('23:00')), live.account.period, LINE.cell))


def test_part_shows_reading_until_first_look_ends(
    bench: ShiftBench,
) -> None:
    assert bench.watch.parts() == {
        'shift': {'shift': None, 'why_not': 'nothing was read yet', 'is_reading': True}
    }
    assert not bench.look()['is_reading']

    def broken() -> Records:
        raise JournalUnusable('it is damaged')

    bench.journal = broken
    assert not bench.look()['is_reading']


def test_the_part_has_the_numbers_of_the_report(bench: ShiftBench) -> None:
    part, expected = bench.look(), report('12:05', journal('12:05'))
    assert {name: part[name] for name in expected['oee']} == expected['oee']
    assert (part['produced'], part['good']) == (518, 500)
    assert {entry['loss']: entry['seconds'] for entry in part['losses']} == {
        loss: seconds for loss, seconds in expected['losses'].items() if abs(seconds) >= 0.05
    }
    assert (part['shift'], part['day'], part['runs']) == ('early', '2026-05-18', True)
    assert (part['begin'], part['at'], part['end']) == (at('06:00'), at('12:05'), at('14:00'))
    stopped = part['stopped']
    assert (stopped['loss'], stopped['since']) == ('emergency', at('12:00'))
    assert (part['why_not'], part['damaged'], part['next']) == ('', 0, None)


def test_ended_shift_names_begin_of_next_shift(
    bench: ShiftBench, clock: Callable[[str], None]
) -> None:
    clock('20:00')
    bench.journal = partial(journal, '20:00')
    part = bench.look()
    assert (part['runs'], part['at'], part['stopped']) == (False, at('14:00'), None)
    assert part['next'] == {'shift': 'early', 'begin': at('06:00') + 24 * 3600}


def test_a_clock_that_was_set_is_said(bench: ShiftBench) -> None:
    part = bench.look()
    assert (part['clock_set'], part['breaks']) == ([], [])
    day = Day()
    day.events = [event for event in the_day().events if event.time <= at('12:00')]
    day.note('11:59:10', ClockStepped(seconds=-50.0))
    bench.journal = day.records
    step = {'seconds': -50.0, 'before': at('12:00'), 'after': at('11:59:10')}
    assert bench.look()['clock_set'] == [step]


def test_stop_begin_follows_the_current_clock(bench: ShiftBench) -> None:
    day = Day()
    day.events = [event for event in the_day().events if event.time <= at('12:00')]
    day.note('12:01:10', ClockStepped(seconds=-50.0))
    bench.journal = day.records
    stopped = bench.look()['stopped']
    assert (stopped['loss'], stopped['since']) == ('emergency', at('11:59:10'))


def test_what_it_lacks_is_said(bench: ShiftBench) -> None:
    def unusable() -> Records:
        raise JournalUnusable('no such file')

    assert bench.look()['why_not'] == ''
    bench.journal = unusable
    assert bench.look() == {**NOTHING, 'why_not': 'no such file'}
    answer = bench.browser().get('/api/shift')
    assert (answer.status, 'no such file' in answer.json['message']) == (503, True)
    bench.journal = lambda: MemoryRecords(MemoryStore('day'))
    assert bench.look() == {**NOTHING, 'why_not': 'the journal has no event yet'}
    store = MemoryStore('other')
    store.append(the_day().events)
    bench.journal = lambda: MemoryRecords(store)
    assert 'give the page the journal that the node writes' in bench.look()['why_not']


def test_it_looks_again_and_tells_the_page(
    bench: ShiftBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watch, 'EVERY_S', 0.0)
    monkeypatch.setattr(watch, 'SOON_S', 0.0)

    def defect() -> Records:
        raise ZeroDivisionError

    def tell() -> None:
        bench.told += 1
        bench.watch.is_wanted = bench.told < 3
        bench.journal = defect if bench.told == 1 else partial(journal, '12:05')
        seen.append(bench.watch.live is not None)

    seen: list[bool] = []
    bench.watch._tell = tell
    bench.loop.run_until_complete(bench.watch.run())
    assert seen == [True, False, True]


def test_the_account_and_its_document(bench: ShiftBench) -> None:
    bench.look()
    live = bench.watch.live
    assert live is not None
    browser = bench.browser()
    assert browser.get('/api/shift').json == live_plain(live)
    answer = browser.get('/api/shift/report.html')
    assert answer.body.decode() == account_page(live.account)
    assert answer.headers['content-type'].startswith('text/html')
    named = "attachment; filename*=UTF-8''shift-early-of-2026-05-18.html"
    assert answer.headers['content-disposition'] == named


def test_shift_by_product_job_component_matches_report(
    bench: ShiftBench,
) -> None:
    bench.look()
    assert bench.watch.live is not None
    made, browser = bench.watch.live.account, bench.browser()
    report = Beside((Column(made.period.name, made.period, made),), made)
    for by in By:
        assert browser.get(f'/api/shift/by/{by.value}').json == beside_plain(report, by)
        document = browser.get(f'/api/shift/days.html?by={by.value}').body.decode()
        assert '<h2>Largest losses</h2>' not in document
        assert all(f'<h2>{group.name}</h2>' in document for group in report.groups(by))
    for address in ('/api/shift/by/shape', '/api/shift/days.html?by=shape'):
        refused = browser.get(address)
        assert refused.status == 400
        assert 'expected product, job or component' in refused.json['message']


def test_the_last_days_are_a_document(bench: ShiftBench) -> None:
    answer = bench.browser().get('/api/shift/days.html')
    read = Reading(journal('12:05'))
    columns = day_columns(PLANT.shifts, date(2026, 5, 18), 7, at('12:05'))
    assert answer.body.decode() == beside_page(beside(read, columns, PLANT.cell), None)
    assert 'Mon 05-18' in answer.body.decode()
    named = "attachment; filename*=UTF-8''2026-05-12-to-2026-05-18.html"
    assert answer.headers['content-disposition'] == named
    bench.journal = lambda: MemoryRecords(MemoryStore('day'))
    answer = bench.browser().get('/api/shift/days.html')
    assert (answer.status, 'it has none at all' in answer.json['message']) == (503, True)


def test_documents_use_the_requested_language(bench: ShiftBench) -> None:
    bench.look()
    browser = bench.browser()
    days = browser.get('/api/shift/days.html?language=de').body.decode()
    assert '<h2>Größte Verluste</h2>' in days
    assert '<h2>Wo die Zeit blieb</h2>' in (
        browser.get('/api/shift/report.html?language=de').body.decode()
    )
    refused = browser.get('/api/shift/days.html?language=fr')
    assert (refused.status, 'de or en' in refused.json['message']) == (422, True)


def test_plant_targets_stand_beside_figures(start: Start, clock: Callable[[str], None]) -> None:
    clock('12:05')
    shifts = parse_shifts(f'{SHIFTS}target: {{oee: 0.75}}\n', 'shifts.yaml')
    bench = start(Plant(shifts, LINE.cell))
    assert bench.look()['targets'] == {'oee': 0.75}
    assert bench.browser().get('/api/shift').json['targets'] == {'oee': 0.75}
    assert 'target 75.0 %' in bench.browser().get('/api/shift/report.html').body.decode()


def test_without_a_file_of_shifts_there_is_nothing(start: Start) -> None:
    bench = start(None)
    bench.loop.run_until_complete(bench.watch.run())
    assert bench.watch.parts() == {}
    for path in ('/api/shift', '/api/shift/report.html', '/api/shift/days.html'):
        answer = bench.browser().get(path)
        assert (answer.status, '--shifts FILE' in answer.json['message']) == (404, True)
    assert samples(bench) == {'bt_orchestrator_node_silent_seconds{node="/n"}': 0.25}


# --- metrics ------------------------------------------------------------------------------------


def samples(bench: ShiftBench) -> dict[str, float]:
    text = bench.browser().get('/metrics').body.decode()
    assert text.endswith('\n# EOF\n')
    lines = [line for line in text.splitlines() if not line.startswith('#')]
    typed = {line.split()[2] for line in text.splitlines() if line.startswith('# TYPE')}
    assert {line.partition('{')[0] for line in lines} <= typed
    assert len({line.rpartition(' ')[0] for line in lines}) == len(lines), 'a sample stands twice'
    return {line.rpartition(' ')[0]: float(line.rpartition(' ')[2]) for line in lines}


def test_metrics_are_the_numbers_of_the_account(bench: ShiftBench) -> None:
    bench.look()
    bench.status = status(cell='test "line"', queued=3)
    metrics = samples(bench)
    of = 'cell="test \\"line\\"",shift="early"'
    expected = report('12:05', journal('12:05'))
    for name, value in expected['oee'].items():
        assert metrics[f'bt_orchestrator_shift_{name}_ratio{{{of}}}'] == value
    for loss in Loss:
        lost = metrics[f'bt_orchestrator_shift_lost_seconds{{{of},loss="{loss.value}"}}']
        assert lost == expected['losses'].get(loss.value, 0)
    made = {
        kind: metrics[f'bt_orchestrator_shift_items{{{of},outcome="{kind}"}}']
        for kind in ('good', 'nonconforming', 'rejected', 'by_hand')
    }
    assert made == {'good': 500, 'nonconforming': 6, 'rejected': 10, 'by_hand': 2}
    cell = 'cell="test \\"line\\""'
    assert metrics[f'bt_orchestrator_jobs_queued{{{cell}}}'] == 3
    assert metrics[f'bt_orchestrator_holds{{{cell}}}'] == len(bench.status.holds)
    states = [value for name, value in metrics.items() if 'cell_state' in name]
    assert (len(states), sum(states)) == (17, 1)
    assert metrics[f'bt_orchestrator_shift_runs{{{of}}}'] == 1


def test_without_pace_oee_metrics_are_left_out(start: Start, clock: Callable[[str], None]) -> None:
    clock('12:05')
    bench = start(Plant(PLANT.shifts, None))
    part = bench.look()
    assert (part['oee'], part['performance'], part['has_pace']) == (None, None, False)
    metrics = samples(bench)
    assert not any('oee' in name or '"slow"' in name for name in metrics)
    assert any('availability' in name for name in metrics)


def test_metrics_format_follows_accept_header(bench: ShiftBench) -> None:
    browser = bench.browser()
    assert browser.get('/metrics').headers['content-type'].startswith('text/plain; version=0.0.4')
    accept = 'application/openmetrics-text;version=1.0.0,text/plain;q=0.5'
    answer = browser.get('/metrics', accept=accept)
    assert answer.headers['content-type'].startswith('application/openmetrics-text; version=1.0.0')
    assert answer.headers['cache-control'] == 'no-store'


def test_exposed_page_requires_view_role_for_metrics(start: Start) -> None:
    bench = start(host='127.0.0.1', proxy_header='X-User')
    assert bench.browser().get('/metrics').status == 401
    assert bench.browser().get('/metrics', x_user='nobody').status == 401
    assert bench.browser().get('/metrics', x_user='vic').status == 200
    assert bench.browser().post('/metrics', x_user='vic').status in (403, 405)
