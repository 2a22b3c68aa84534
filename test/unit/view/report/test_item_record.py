"""The record of one item: it tells the story to somebody who was not there."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import datetime
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from fakes.journal_reading import journal_reading
from fakes.line import Line, with_section
from fakes.long_journal import LongRun
from fakes.profiles import examples
from fakes.stepped import Steps, drawn_steps, stepped
from fakes.told_item import BEGIN, ITEM, ToldItem
from fakes.told_waits import recorded_as_told
from fakes.virtual_run import VirtualRun
from hypothesis import given

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.events import CycleStarted, Event, HoldReleased, OrchestratorStarted
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.state import CellState
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.drawing.documents.item_page import Source, item_page
from bt_orchestrator.view.report.item.fold import ItemFold
from bt_orchestrator.view.report.item.history import Attempt, Decision, ItemHistory, plain_item
from bt_orchestrator.view.report.item.reader import item_history
from bt_orchestrator.view.report.item.story import CLOCK, NOT_TOLD, Entry, chapters, time_uses
from bt_orchestrator.view.report.reading import Reading

WAITING = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - {id: fetch, @arm}
    - parallel: [{id: left, @a2}, [{id: right, @b2}, {id: turn, @arm.TASK_B}]]
  3:
    - {id: join, @a3}
    - {id: stamp, @arm.TASK_C}
    - {id: pack, @b3, qty_change: -1}
lateral_dependencies:
  - {flag: room, upstream: join, downstream: fetch, initial: 1}
zones: {table: [left, pack]}
"""


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return ToldItem().write(tmp_path_factory.mktemp('record') / 'cell.sqlite3')


@pytest.fixture(scope='module')
def record(journal: Path) -> ItemHistory:
    with journal_reading(journal) as reading:
        history = item_history(reading, ITEM)
    assert history is not None
    return history


def entries(history: ItemHistory, kind: str) -> list[Entry]:
    return [step for chapter in chapters(history) for step in chapter.entries if step.kind == kind]


def test_record_shows_waits_and_end_of_attempts(record: ItemHistory) -> None:
    press = [attempt for attempt in entries(record, 'task') if attempt.what.startswith('press')]
    assert [(attempt.what, attempt.seconds, attempt.words) for attempt in press] == [
        ('press', 1.0, 'failed: aborted (aborted by the simulated controller)'),
        ('press, attempt 2', 1.0, 'failed: aborted (aborted by the simulated controller)'),
        ('press, attempt 3', 12.0, 'done'),
    ]
    assert [[(round(w.seconds, 3), w.words) for w in attempt.waited] for attempt in press] == [
        [
            (3.0, 'waiting for section 2 to finish with WO-7/1'),
            (2.0, 'waiting for the belt to rest'),
        ],
        [(2.0, 'waiting to retry, attempt 2')],
        [(41.0, 'waiting for an answer to hold 1 (press: aborted)')],
    ]
    assert ('arguments', 'special_argument_1: deep') in press[0].details


def test_record_shows_answers_reasons_and_restart(record: ItemHistory) -> None:
    assert [(entry.what, entry.words) for entry in entries(record, 'decision')] == [
        ('Ann, engineer, decided retry of hold 1', 'the part sat askew'),
        ('Ben, engineer, decided resume of hold 2', 'belt and gripper looked at'),
    ]
    assert [(entry.what, entry.seconds) for entry in entries(record, 'hold')] == [
        ('hold 1, press', 41.0),
        ('hold 2, the whole cell', 20.0),
    ]
    (restart,) = entries(record, 'restart')
    assert restart.what.startswith('the orchestrator was started again, 12.0 s after')


def test_the_end_says_why(record: ItemHistory) -> None:
    assert (record.how, record.lots) == ('rejected', {'grease': 'L-77'})
    assert 'found 7.5' in record.rejected
    weigh = next(entry for entry in entries(record, 'task') if entry.what == 'weigh')
    assert ('refused', 'item_present: true, measurement: 7.5') in weigh.details


def test_what_stood_and_worked_beside_it_is_told(record: ItemHistory) -> None:
    assert [(chapter.title, chapter.beside) for chapter in chapters(record)] == [
        ('Section 1', 'section 2: WO-7/1'),
        ('Section 2', 'section 1: WO-7/3'),
        ('Section 3', 'section 2: WO-7/3'),
    ]
    place = entries(record, 'task')[0]
    assert ('at work at the same time', 'a2 TASK_A (WO-7/1)') in place.details


def test_passed_failure_makes_item_nonconforming() -> None:
    line = Line(3, faults={'b2': '#1=abort'})
    section = '{id: work, @a2}, {id: check, @b2, on_failure: continue}'
    run = line.run(with_section(2, f'[{section}]'), 2)
    outcomes = []
    for name in ('J/1', 'J/2'):
        fold = ItemFold(name, 'J')
        for event in run.store.read():
            fold.follow(event)
        outcomes.append((fold.history.how, fold.history.nonconforming))
    assert outcomes == [('packed', ['check']), ('packed', [])]


def test_all_of_its_time_is_accounted_for(record: ItemHistory) -> None:
    assert record.started is not None
    assert record.ended is not None
    uses = time_uses(record)
    assert sum(use.seconds for use in uses) == pytest.approx(record.ended - record.started)
    assert 'something that the journal does not tell' not in ' '.join(use.words for use in uses)


@examples(20, 300)
@given(drawn_steps())
def test_a_clock_that_is_set_changes_no_duration(journal: Path, steps: Steps) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
        plain = item_history(reading, ITEM)
    store = MemoryStore()
    store.append(stepped(events, steps))
    history = item_history(Reading(MemoryRecords(store)), ITEM)
    assert plain is not None
    assert history is not None
    assert story(history) == story(plain)


def story(history: ItemHistory) -> list[object]:
    begun = history.started
    assert begun is not None
    entries = [
        (row.kind, row.what, row.words, row.outcome, pytest.approx(row.time - begun, abs=1e-4))
        for chapter in chapters(history)
        for row in chapter.entries
        if row.kind != CLOCK
    ]
    uses = [(use.words, use.kind, round(use.seconds, 4)) for use in time_uses(history)]
    return [*entries, *uses]


def test_clock_step_is_entry_of_item_record(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
    store = MemoryStore()
    store.append(stepped(events, [(60, -50.0)]))
    history = item_history(Reading(MemoryRecords(store)), ITEM)
    assert history is not None
    assert [step.what for step in entries(history, CLOCK)] == ['the clock was set back by 50.0 s']
    assert [step['seconds'] for step in plain_item(history)['clock_set']] == [-50.0]


def test_item_waits_match_what_line_reported() -> None:
    """At every moment of a run with an arm, a flag and a zone."""
    line = Line(3, seconds={'a2': 3.0, 'b3': 4.0, 'arm': 1.5})
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(WAITING), 4)
    run.go()
    assert recorded_as_told(run)
    waited = [
        w for n in range(1, 5) for task in history_of(run, f'J/{n}').tasks for w in task.waited
    ]
    assert {w.kind for w in waited} >= {'belt', 'turn', 'component', 'flag', 'zone'}


DELAYED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: weigh, @arm, retries: 1, retry_delay: 1.0}]
  3: [{id: join, @a3}, {id: stamp, @arm.TASK_B}, {id: pack, @b3, qty_change: -1}]
"""


def history_of(run: VirtualRun, item: str = 'J/1') -> ItemHistory:
    history = item_history(Reading(MemoryRecords(run.store)), item)
    assert history is not None
    return history


def test_retry_waits_for_delay_then_for_arm() -> None:
    """The arm is taken while the delay lasts, and for much longer."""
    seconds = {'a3': 0.5, 'arm': 20.0}
    line = Line(3, seconds=seconds, faults={'arm': 'TASK_A#2=reject'})
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(DELAYED), 2)
    run.go()
    tasks = history_of(run, 'J/2').tasks
    (again,) = (task for task in tasks if (task.task, task.attempt) == ('weigh', 2))
    assert [(w.kind, round(w.seconds, 3)) for w in again.waited] == [
        ('retry_delay', 1.0),
        ('component', 19.5),
    ]


def test_rejected_item_waits_for_holds_of_line() -> None:
    text = """
    sections:
      1: [{id: place, @a1, qty_change: 1}]
      2: [{id: work, @a2, on_failure: reject}]
      3: [{id: skipped, @b3}, {id: pack, @a3, qty_change: -1, runs_for: all}]
    """
    line = Line(3, faults={'a2': '#1=abort', 'a1': '#2=abort'})
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(text), 2)
    run.go()
    run.sim.clock.call_at(run.now + 100.0, lambda: None)
    run.go(until=run.now + 100.0)
    run.answer('mark_done')
    run.go()
    history = history_of(run)
    assert history.rejected
    uses = {use.words: use.seconds for use in time_uses(history)}
    assert 'neither worked on nor waiting for a task' not in uses
    assert uses['waiting for an answer to hold 1 (place: aborted)'] >= 100.0


def without_cell(events: Iterable[Event]) -> list[Event]:
    """Return events as programs wrote them that did not note the cell."""
    return [
        replace(event, cell_definition=None) if isinstance(event, OrchestratorStarted) else event
        for event in events
    ]


def uses_in(events: Sequence[Event]) -> dict[str, float]:
    store = MemoryStore()
    store.append(events)
    history = item_history(Reading(MemoryRecords(store)), ITEM)
    assert history is not None
    assert history.ended is not None
    assert history.started is not None
    uses = time_uses(history)
    assert sum(u.seconds for u in uses) == pytest.approx(history.ended - history.started)
    return {use.words: use.seconds for use in uses}


def test_older_journal_marks_waits_as_unknown(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = without_cell(reading.events(Wanted()))
    uses = uses_in(events)
    assert list(uses) == ['worked on', NOT_TOLD]
    assert uses[NOT_TOLD] == pytest.approx(72.0)


def test_later_start_names_cell_of_older_journal(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
    (first, second) = (event for event in events if isinstance(event, OrchestratorStarted))
    older = [*without_cell(events[: second.seq - 1]), *events[second.seq - 1 :]]
    assert first.cell_definition == second.cell_definition
    assert uses_in(older) == uses_in(events)
    assert NOT_TOLD not in uses_in(events)


def test_waits_after_damaged_event_are_unknown(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
        whole = item_history(reading, ITEM)
    lost = next(entry.seq for entry in events if isinstance(entry, HoldReleased))
    fold = ItemFold(ITEM, 'WO-7', CellState(ToldItem().line.cell))
    for event in events:
        if event.seq != lost:
            fold.follow(event)
    assert whole is not None
    press = [entry.waited for entry in whole.tasks if entry.task == 'press']
    assert [entry.waited for entry in fold.history.tasks if entry.task == 'press'] == press
    idle_words = [entry.words for entry in fold.history.idle]
    assert idle_words.count('') == len(idle_words) > 0


def test_cell_is_known_without_start_event(tmp_path: Path) -> None:
    run = LongRun(tmp_path / 'cell.sqlite3', keep_jobs=2)
    for number in range(40):
        run.job(f'J{number}')
        run.rest(30)
    run.close()
    with journal_reading(tmp_path / 'cell.sqlite3') as reading:
        assert reading.records.extent().first_seq > 1
        history = item_history(reading, 'J39/2')
    assert history is not None
    assert [w.kind for task in history.tasks for w in task.waited]
    assert NOT_TOLD not in {use.words for use in time_uses(history)}


# --- the verb -----------------------------------------------------------------------------------


class _Text(HTMLParser):
    """Reads a document: its words, and what it would load."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.words: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.loads += [value or '' for name, value in attrs if name in ('src', 'href')]
        assert tag not in ('script', 'link')


@pytest.fixture
def words(journal: Path) -> list[str]:
    return ['history', '--journal', str(journal)]


def test_document_tells_story_without_other_files(words: list[str], tmp_path: Path) -> None:
    file = tmp_path / 'item.html'
    assert main([*words, '--item', ITEM, '--html', '-o', str(file)]) == 0
    text = file.read_text()
    page = _Text(text)
    assert page.loads == []
    assert 'http' not in text.replace('http://www.w3.org', '')
    page_text = ' '.join(page.words)
    for term in ('rejected', 'the part sat askew', 'aborted by the simulated controller', 'L-77'):
        assert term in page_text
    assert '@media print' in text


def test_json_has_the_same(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, '--item', ITEM, '--record']) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record['item'], record['how'], len(record['restarts'])) == (ITEM, 'rejected', 1)
    assert (
        record['tasks'][1]['waited'][0]['words'] == 'waiting for section 2 to finish with WO-7/1'
    )


def test_lot_has_list_and_record_per_item(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, '--lot', 'grease=L-77', '--html']) == 0
    page = _Text(capsys.readouterr().out)
    assert page.loads == ['#WO-7/1', '#WO-7/2', '#WO-7/3']
    assert page.words.count('Item record') == 3


def test_mistakes_are_sentences(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, '--item', 'WO-7/9', '--html']) == 1
    assert 'knows no item WO-7/9' in capsys.readouterr().err
    assert main([*words, '--html']) == 2
    assert 'say which: --item ITEM' in capsys.readouterr().err
    assert main([*words, '--item', ITEM, '--html', '-o', str(tmp_path / 'no' / 'x.html')]) == 2
    assert 'cannot write' in capsys.readouterr().err


@pytest.mark.parametrize('begin', range(0, 120, 24))
def test_what_is_left_of_a_journal_is_told(journal: Path, begin: int) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted(after_seq=begin, before_seq=begin + 70)))
    fold = ItemFold(ITEM, 'WO-7')
    for event in events:
        fold.follow(event)
    text = item_page([fold.history], Source('the rest', events[-1].time), 'Item')
    begun = any(
        isinstance(row, CycleStarted) and (row.item, row.section) == (ITEM, 1) for row in events
    )
    assert ('does not have the beginning' in text) != begun
    assert ('class="badge"' in text) == (fold.history.ended is None)


def test_what_devices_and_people_write_breaks_no_document() -> None:
    bad = '<script>alert(1)</script>\x00\ud800&"'
    item = ItemHistory('A/1', 'A', started=0.0, ended=2.0, how='packed', params={'p': bad})
    item.tasks.append(Attempt(1, bad, 'failed', bad, bad, started=0.0, ended=1.0, message=bad))
    item.decisions.append(Decision(1.0, bad, bad, bad))
    text = item_page([item], Source(bad, 3.0), bad)
    assert '<script' not in text
    assert '\x00' not in text
    assert text.encode()


# --- the chart of what happened -----------------------------------------------------------------


def test_a_chart_shows_what_each_component_really_did(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, '--gantt', '--job', 'WO-7']) == 0
    svg = ET.fromstring(capsys.readouterr().out.partition('?>')[2])
    rows = {part.get('id'): part for part in svg.iter() if part.tag.endswith('}g')}
    assert list(rows) == ['cell', 'a1', 'a2', 'arm', 'b2', 'a3', 'conveyor', 'legend']
    titles = [part.text or '' for part in rows['a2'].iter() if part.tag.endswith('}title')]
    assert len(titles) == 6
    assert titles[2].splitlines()[0] == 'press of WO-7/2: TASK_A at a2'
    assert titles[2].splitlines()[2] == 'aborted'
    assert titles[0].startswith('hold 1: section 2, press (TASK_A) of WO-7/2 at a2')
    arm = [part.text or '' for part in rows['arm'].iter() if part.tag.endswith('}title')]
    assert {'screw_right of WO-7/1', 'weigh of WO-7/1'} <= {part.split(':')[0] for part in arm}


def test_chart_is_cut_to_requested_period(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    begin, end = (datetime.fromtimestamp(BEGIN + s).isoformat() for s in (20.0, 60.0))
    assert main([*words, '--gantt', '--from', begin, '--to', end]) == 0
    svg = ET.fromstring(capsys.readouterr().out.partition('?>')[2])
    assert [part.get('id') for part in svg.iter() if part.tag.endswith('}g')] == ['a2', 'legend']


@pytest.mark.parametrize(
    ('options', 'status', 'message'),
    [
        (['--job', 'WO-9'], 1, 'knows no job WO-9'),
        (['--from', '2001-01-01', '--to', '2001-01-02'], 1, 'no component worked'),
        (['--job', 'WO-7', '--from', '2001-01-01'], 2, 'leave one out'),
    ],
)
def test_a_chart_of_nothing_is_a_sentence(
    words: list[str],
    options: list[str],
    status: int,
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([*words, '--gantt', *options]) == status
    assert message in capsys.readouterr().err
