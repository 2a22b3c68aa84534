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
    return ToldItem().write(tmp_path_factory.mktemp('told') / 'cell.sqlite3')


@pytest.fixture(scope='module')
def told(journal: Path) -> ItemHistory:
    with journal_reading(journal) as reading:
        history = item_history(reading, ITEM)
    assert history is not None
    return history


def entries(history: ItemHistory, kind: str) -> list[Entry]:
    return [one for chapter in chapters(history) for one in chapter.entries if one.kind == kind]


def test_every_attempt_stands_there_with_its_wait_and_how_it_ended(told: ItemHistory) -> None:
    press = [one for one in entries(told, 'task') if one.what.startswith('press')]
    assert [(one.what, one.seconds, one.words) for one in press] == [
        ('press', 1.0, 'failed: aborted (aborted by the simulated controller)'),
        ('press, attempt 2', 1.0, 'failed: aborted (aborted by the simulated controller)'),
        ('press, attempt 3', 12.0, 'done'),
    ]
    assert [[(round(w.seconds, 3), w.words) for w in one.waited] for one in press] == [
        [
            (3.0, 'waiting for section 2 to finish with WO-7/1'),
            (2.0, 'waiting for the belt to rest'),
        ],
        [(2.0, 'waiting to retry, attempt 2')],
        [(41.0, 'waiting for an answer to hold 1 (press: aborted)')],
    ]
    assert ('arguments', 'special_argument_1: deep') in press[0].details


def test_who_answered_and_why_and_the_restart_are_told(told: ItemHistory) -> None:
    assert [(one.what, one.words) for one in entries(told, 'decision')] == [
        ('Ann, engineer, decided retry of hold 1', 'the part sat askew'),
        ('Ben, engineer, decided resume of hold 2', 'belt and gripper looked at'),
    ]
    assert [(one.what, one.seconds) for one in entries(told, 'hold')] == [
        ('hold 1, press', 41.0),
        ('hold 2, the whole cell', 20.0),
    ]
    (restart,) = entries(told, 'restart')
    assert restart.what.startswith('the orchestrator was started again, 12.0 s after')


def test_the_end_says_why(told: ItemHistory) -> None:
    assert (told.how, told.lots) == ('rejected', {'grease': 'L-77'})
    assert 'found 7.5' in told.rejected
    weigh = next(one for one in entries(told, 'task') if one.what == 'weigh')
    assert ('refused', 'item_present: true, measurement: 7.5') in weigh.details


def test_what_stood_and_worked_beside_it_is_told(told: ItemHistory) -> None:
    assert [(one.title, one.beside) for one in chapters(told)] == [
        ('Section 1', 'section 2: WO-7/1'),
        ('Section 2', 'section 1: WO-7/3'),
        ('Section 3', 'section 2: WO-7/3'),
    ]
    place = entries(told, 'task')[0]
    assert ('at work at the same time', 'a2 TASK_A (WO-7/1)') in place.details


def test_a_task_that_failed_and_was_passed_makes_the_item_nonconforming() -> None:
    line = Line(3, faults={'b2': '#1=abort'})
    section = '{id: work, @a2}, {id: check, @b2, on_failure: continue}'
    run = line.run(with_section(2, f'[{section}]'), 2)
    found = []
    for name in ('J/1', 'J/2'):
        fold = ItemFold(name, 'J')
        for event in run.store.read():
            fold.follow(event)
        found.append((fold.history.how, fold.history.nonconforming))
    assert found == [('packed', ['check']), ('packed', [])]


def test_all_of_its_time_is_accounted_for(told: ItemHistory) -> None:
    assert told.started is not None
    assert told.ended is not None
    uses = time_uses(told)
    assert sum(use.seconds for use in uses) == pytest.approx(told.ended - told.started)
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
        (one.kind, one.what, one.words, one.outcome, pytest.approx(one.time - begun, abs=1e-4))
        for chapter in chapters(history)
        for one in chapter.entries
        if one.kind != CLOCK
    ]
    uses = [(use.words, use.kind, round(use.seconds, 4)) for use in time_uses(history)]
    return [*entries, *uses]


def test_a_step_of_the_clock_is_an_entry_of_the_story(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
    store = MemoryStore()
    store.append(stepped(events, [(60, -50.0)]))
    history = item_history(Reading(MemoryRecords(store)), ITEM)
    assert history is not None
    assert [one.what for one in entries(history, CLOCK)] == ['the clock was set back by 50.0 s']
    assert [one['seconds'] for one in plain_item(history)['clock_set']] == [-50.0]


def test_what_an_item_waited_for_is_what_the_line_said_at_the_time() -> None:
    """At every moment of a run with an arm, a flag and a zone."""
    line = Line(3, seconds={'a2': 3.0, 'b3': 4.0, 'arm': 1.5})
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(WAITING), 4)
    run.go()
    assert recorded_as_told(run)
    waited = [
        w for n in range(1, 5) for one in history_of(run, f'J/{n}').tasks for w in one.waited
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


def test_a_retry_waits_for_its_delay_and_then_for_the_arm() -> None:
    """The arm is taken while the delay lasts, and for much longer."""
    seconds = {'a3': 0.5, 'arm': 20.0}
    line = Line(3, seconds=seconds, faults={'arm': 'TASK_A#2=reject'})
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(DELAYED), 2)
    run.go()
    tasks = history_of(run, 'J/2').tasks
    (again,) = (one for one in tasks if (one.task, one.attempt) == ('weigh', 2))
    assert [(w.kind, round(w.seconds, 3)) for w in again.waited] == [
        ('retry_delay', 1.0),
        ('component', 19.5),
    ]


def test_a_rejected_item_waits_for_the_holds_that_stop_the_line() -> None:
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
        replace(one, cell_definition=None) if isinstance(one, OrchestratorStarted) else one
        for one in events
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


def test_an_older_journal_says_that_it_does_not_tell(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = without_cell(reading.events(Wanted()))
    uses = uses_in(events)
    assert list(uses) == ['worked on', NOT_TOLD]
    assert uses[NOT_TOLD] == pytest.approx(72.0)


def test_a_later_start_tells_an_older_journal_which_cell_it_was(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
    (first, second) = (one for one in events if isinstance(one, OrchestratorStarted))
    older = [*without_cell(events[: second.seq - 1]), *events[second.seq - 1 :]]
    assert first.cell_definition == second.cell_definition
    assert uses_in(older) == uses_in(events)
    assert NOT_TOLD not in uses_in(events)


def test_behind_a_damaged_event_it_is_not_told_what_was_waited_for(journal: Path) -> None:
    with journal_reading(journal) as reading:
        events = list(reading.events(Wanted()))
        whole = item_history(reading, ITEM)
    lost = next(one.seq for one in events if isinstance(one, HoldReleased))
    fold = ItemFold(ITEM, 'WO-7', CellState(ToldItem().line.cell))
    for event in events:
        if event.seq != lost:
            fold.follow(event)
    assert whole is not None
    press = [one.waited for one in whole.tasks if one.task == 'press']
    assert [one.waited for one in fold.history.tasks if one.task == 'press'] == press
    told = [one.words for one in fold.history.idle]
    assert told.count('') == len(told) > 0


def test_the_cell_is_known_when_the_start_of_the_node_is_removed(tmp_path: Path) -> None:
    run = LongRun(tmp_path / 'cell.sqlite3', keep_jobs=2)
    for number in range(40):
        run.job(f'J{number}')
        run.rest(30)
    run.close()
    with journal_reading(tmp_path / 'cell.sqlite3') as reading:
        assert reading.records.extent().first_seq > 1
        history = item_history(reading, 'J39/2')
    assert history is not None
    assert [w.kind for one in history.tasks for w in one.waited]
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


def test_a_document_has_the_story_and_needs_no_other_file(
    words: list[str], tmp_path: Path
) -> None:
    file = tmp_path / 'item.html'
    assert main([*words, '--item', ITEM, '--html', '-o', str(file)]) == 0
    text = file.read_text()
    page = _Text(text)
    assert page.loads == []
    assert 'http' not in text.replace('http://www.w3.org', '')
    told = ' '.join(page.words)
    for said in ('rejected', 'the part sat askew', 'aborted by the simulated controller', 'L-77'):
        assert said in told
    assert '@media print' in text


def test_json_has_the_same(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*words, '--item', ITEM, '--record']) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record['item'], record['how'], len(record['restarts'])) == (ITEM, 'rejected', 1)
    assert (
        record['tasks'][1]['waited'][0]['words'] == 'waiting for section 2 to finish with WO-7/1'
    )


def test_a_lot_has_a_list_and_a_record_of_each_item(
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
        isinstance(one, CycleStarted) and (one.item, one.section) == (ITEM, 1) for one in events
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
    rows = {one.get('id'): one for one in svg.iter() if one.tag.endswith('}g')}
    assert list(rows) == ['cell', 'a1', 'a2', 'arm', 'b2', 'a3', 'conveyor', 'legend']
    told = [one.text or '' for one in rows['a2'].iter() if one.tag.endswith('}title')]
    assert len(told) == 6
    assert told[2].splitlines()[0] == 'press of WO-7/2: TASK_A at a2'
    assert told[2].splitlines()[2] == 'aborted'
    assert told[0].startswith('hold 1: section 2, press (TASK_A) of WO-7/2 at a2')
    arm = [one.text or '' for one in rows['arm'].iter() if one.tag.endswith('}title')]
    assert {'screw_right of WO-7/1', 'weigh of WO-7/1'} <= {one.split(':')[0] for one in arm}


def test_a_chart_of_a_stretch_of_time_is_cut_there(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    begin, end = (datetime.fromtimestamp(BEGIN + s).isoformat() for s in (20.0, 60.0))
    assert main([*words, '--gantt', '--from', begin, '--to', end]) == 0
    svg = ET.fromstring(capsys.readouterr().out.partition('?>')[2])
    assert [one.get('id') for one in svg.iter() if one.tag.endswith('}g')] == ['a2', 'legend']


@pytest.mark.parametrize(
    ('options', 'status', 'said'),
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
    said: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([*words, '--gantt', *options]) == status
    assert said in capsys.readouterr().err
