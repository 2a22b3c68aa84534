"""The past, from a journal file and over the door."""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, cast

import pytest
from fakes.line import TYPES, Line, with_section
from fakes.stepped import stepped
from fakes.virtual_run import VirtualRun

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.engine.runtime.overview import description_of
from bt_orchestrator.extensions.page.web.archive.archive import Archive, Look
from bt_orchestrator.extensions.page.web.archive.ended_jobs import job_with_items, jobs_page
from bt_orchestrator.extensions.page.web.archive.endpoints import Choice, alarms_page, events_page
from bt_orchestrator.extensions.page.web.archive.heard import Heard, HeardRecords
from bt_orchestrator.extensions.page.web.archive.histories import Subject, history_of, item_record
from bt_orchestrator.model.events import Event, HoldRaised
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports.doors.following_door import Happened
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore

LIST = '[{id: work, @a2, args: {special_argument_1: lot}}, {id: also, @b2}]'


@pytest.fixture(scope='module')
def run() -> VirtualRun:
    """Two jobs: a task fails twice, one item is taken off the belt."""
    line = Line(3, faults={'a2': 'TASK_A#1=abort TASK_A#3=abort'}, seconds={'b2': 3.0})
    run = VirtualRun(line.cell, line.types)
    script = line.script(with_section(2, LIST))
    run.submit('J', script, 3)
    run.submit('K', script, 2)
    run.go()
    run.answer('retry')
    run.go()
    run.answer('skip')
    run.go(until=run.now + 1.5)
    run.pause()
    standing = [s.slot for s in run.state.sections.values() if s.slot]
    assert run.remove(standing[-1]).accepted
    run.resume()
    run.go()
    assert run.ended
    return run


@pytest.fixture(scope='module')
def journal(run: VirtualRun, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    path = tmp_path_factory.mktemp('journal') / 'cell.sqlite3'
    store = SqliteStore(path)
    store.append(list(run.store.read()))
    yield path
    store.close()


Ask = Callable[[Callable[[Look], Any]], Any]


def of_journal(path: Path) -> Ask:
    return lambda question: _read(
        Archive(cast('Heard', None), lambda: SqliteRecords(path)), question
    )


def of_door(run: VirtualRun) -> Ask:
    class Known:
        async def records(self) -> HeardRecords:
            return HeardRecords('', 0, [Happened(event) for event in run.store.read()])

    return lambda question: _read(Archive(cast('Heard', Known())), question)


def _read(archive: Archive, question: Callable[[Look], Any]) -> Any:
    try:
        return asyncio.run(archive.read(question))
    finally:
        archive.close()


@pytest.fixture(params=['journal', 'door'])
def ask(request: pytest.FixtureRequest, run: VirtualRun, journal: Path) -> Ask:
    return of_journal(journal) if request.param == 'journal' else of_door(run)


QUESTIONS: list[Callable[[Look], Any]] = [
    lambda look: jobs_page(look, '', 10),
    lambda look: job_with_items(look, 'J'),
    lambda look: item_record(look, 'J/1'),
    lambda look: item_record(look, 'J/2'),
    lambda look: history_of(look, Subject(section=2), 100.0, None),
    lambda look: history_of(look, Subject(component='a2'), 100.0, None),
]


@pytest.mark.parametrize('question', QUESTIONS)
def test_a_journal_and_the_door_tell_the_same(
    run: VirtualRun, journal: Path, question: Callable[[Look], Any]
) -> None:
    assert of_journal(journal)(question) == of_door(run)(question)


def test_jobs_come_newest_first_by_pages(ask: Ask) -> None:
    first = ask(lambda look: jobs_page(look, '', 1))
    assert [job['id'] for job in first['jobs']] == ['K']
    second = ask(lambda look: jobs_page(look, first['rest'], 1))
    (job,) = second['jobs']
    assert (job['id'], job['status'], job['is_whole']) == ('J', 'completed', True)
    end = ask(lambda look: jobs_page(look, second['rest'], 1))
    assert (end['jobs'], end['rest']) == ([], None)


def test_an_item_has_every_attempt_and_who_decided(ask: Ask) -> None:
    record = ask(lambda look: item_record(look, 'J/1'))
    tries = [(task['task'], task['attempt'], task['outcome']) for task in record['tasks']]
    assert tries == [
        ('place', 1, 'succeeded'),
        ('work', 1, 'failed'),
        ('work', 2, 'succeeded'),
        ('also', 1, 'succeeded'),
        ('pack', 1, 'succeeded'),
    ]
    failed = record['tasks'][1]
    assert (failed['section'], failed['component'], failed['name']) == (2, 'a2', 'TASK_A')
    assert (failed['seconds'], failed['reason']) == (1.0, 'aborted')
    assert failed['args'] == {'special_argument_1': 'lot'}
    (decision,) = record['decisions']
    assert (decision['who'], decision['what'], decision['reason']) == (
        'Ann',
        'retry',
        'it looked so',
    )
    assert (record['script'], record['how']) == ('test', 'packed')


def test_skipped_task_is_listed_with_reason(ask: Ask) -> None:
    record = ask(lambda look: item_record(look, 'J/2'))
    skipped = next(task for task in record['tasks'] if task['outcome'] == 'skipped')
    assert skipped['task'] == 'work'
    assert 'Ann decided skip' in skipped['reason']


def test_manual_removal_is_recorded_with_decision(run: VirtualRun, ask: Ask) -> None:
    (gone,) = run.all('item.removed', how='by_hand')
    record = ask(lambda look: item_record(look, gone['item']))
    assert record['how'] == 'by_hand'
    assert [decision['what'] for decision in record['decisions']][-1] == 'remove_item'


def test_nothing_is_made_up_about_what_never_was(ask: Ask) -> None:
    assert ask(lambda look: item_record(look, 'J/99')) is None
    assert ask(lambda look: job_with_items(look, 'X')) is None


def test_the_history_of_a_section(run: VirtualRun, ask: Ask) -> None:
    described = description_of(run.state.cell, TYPES)
    end = run.records[-1]['time']
    history = ask(lambda look: history_of(look, Subject(section=2), end, described))
    cycles = history['cycles']
    done = run.all('cycle.completed', section=2)
    assert [entry['item'] for entry in cycles] == [entry['item'] for entry in reversed(done)]
    assert history['tasks']['b2.TASK_A']['nominal_s'] == 3.0
    assert history['tasks']['b2.TASK_A']['lately_s'] == 3.0
    assert [entry['reason'] for entry in history['failures']] == ['aborted', 'aborted']
    assert sum(history['time_in'].values()) == pytest.approx(end - run.records[0]['time'], abs=1.0)
    works = sum(entry['seconds'] for cycle in cycles for entry in cycle['tasks'])
    assert history['time_in']['works'] == pytest.approx(works)


def test_the_history_of_a_component(run: VirtualRun, ask: Ask) -> None:
    history = ask(lambda look: history_of(look, Subject(component='a2'), 1000.0, None))
    assert {task['component'] for cycle in history['cycles'] for task in cycle['tasks']} == {'a2'}
    assert len(history['failures']) == len(run.all('task.failed'))
    assert list(history['tasks']) == ['TASK_A']


def test_events_by_pages_in_both_directions(run: VirtualRun, ask: Ask) -> None:
    newest = ask(lambda look: events_page(look, Wanted(newest_first=True), 3))
    assert newest['records'] == run.records[:-4:-1]
    before = newest['rest']['before']
    more = ask(lambda look: events_page(look, Wanted(newest_first=True, before_seq=before), 2))
    assert more['records'] == run.records[-4:-6:-1]
    after = ask(lambda look: events_page(look, Wanted(after_seq=5), 2))
    assert (after['records'], after['rest']) == (run.records[5:7], {'after': 7})


def test_damage_is_told_and_the_rest_is_shown(
    run: VirtualRun, journal: Path, tmp_path: Path
) -> None:
    copy = tmp_path / 'copy.sqlite3'
    store = SqliteStore(copy)
    store.append(list(run.store.read()))
    store.close()
    (gone,) = (entry['seq'] for entry in run.all('task.failed', item='J/1'))
    with sqlite3.connect(copy) as database:
        database.execute('DELETE FROM events WHERE seq = ?', (gone,))
    database.close()
    record = of_journal(copy)(lambda look: item_record(look, 'J/1'))
    (damage,) = record['damage']
    assert f'event {gone}' in damage
    assert [entry['outcome'] for entry in record['tasks']].count('running') == 1, 'its end is lost'


def test_unreadable_journal_raises_its_own_error(tmp_path: Path) -> None:
    with pytest.raises(JournalUnusable):
        of_journal(tmp_path / 'none')(lambda look: look.extent)


def test_a_journal_of_another_node_is_told(journal: Path) -> None:
    async def why(history: str) -> str:
        archive = Archive(cast('Heard', None), lambda: SqliteRecords(journal), lambda: history)
        extent = await archive.read(lambda look: look.extent)
        archive.close()
        return archive.why_not_whole(extent)

    with closing(SqliteRecords(journal)) as records:
        own = records.extent().history
    assert asyncio.run(why(own)) == ''
    assert asyncio.run(why('')) == '', 'the node is silent'
    assert 'the node has other: give the page the journal' in asyncio.run(why('other'))


def test_job_and_item_durations_ignore_clock_steps(run: VirtualRun, tmp_path: Path) -> None:
    def seconds(events: list[Event]) -> dict[str, float]:
        path = tmp_path / f'{hash(tuple(entry.time for entry in events))}.sqlite3'
        with closing(SqliteStore(path)) as store:
            store.append(events)
            record = of_journal(path)(lambda look: job_with_items(look, 'J'))
        return {entry['id']: entry['seconds'] for entry in (record['job'], *record['items'])}

    events = list(run.store.read())
    as_it_was = seconds(events)
    assert len(as_it_was) == 4
    for by_s in (-3600.0, 3600.0):
        assert seconds(stepped(events, [(20, by_s)])) == pytest.approx(as_it_was)


def test_alarms_match_journal_in_every_language(ask: Ask, run: VirtualRun) -> None:
    raised = [entry for entry in run.store.read() if isinstance(entry, HoldRaised)]
    page = ask(lambda look: alarms_page(look, Choice()))
    holds = [entry for entry in page['alarms'] if entry['kind'] == 'hold']
    assert [entry['raised'] for entry in holds] == [entry.time for entry in reversed(raised)]
    aborted = [entry for entry in holds if entry['reason'] == 'aborted']
    assert [entry['answer'] for entry in aborted] == ['skip', 'retry']
    assert {entry['component'] for entry in aborted} == {'a2'}
    assert set(aborted[0]['said']) == {'en', 'de'}
    assert {'kind': 'hold', 'about': 'a2', 'reason': 'aborted', 'times': 2} in page['counts']
    assert not ask(lambda look: alarms_page(look, Choice(is_open=True)))['alarms']
    of_a2 = ask(lambda look: alarms_page(look, Choice('hold', 'a2')))
    assert (len(of_a2['alarms']), of_a2['is_cut']) == (2, False)
