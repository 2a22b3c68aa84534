"""Pictures and exports of a journal whose clock was set: they keep the time that passed."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from contextlib import closing
from datetime import datetime
from pathlib import Path

import pytest
from fakes.line import Line, with_section
from fakes.stepped import stepped
from fakes.virtual_run import VirtualRun

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.events import Event, OrchestratorStarted
from bt_orchestrator.store.sqlite.store import SqliteStore

SVG = '{http://www.w3.org/2000/svg}'
XES = '{http://www.xes-standard.org/}'
AT = 36_000.0
"""When the run begins: a clock that is set back by an hour shows no time before 1970."""

either_way = pytest.mark.parametrize('by_s', [-3600.0, 3600.0, -5.0])


@pytest.fixture(scope='module')
def events() -> Sequence[Event]:
    """What happened in a run with a failed attempt and a hold."""
    line = Line(3, faults={'a2': 'TASK_A#2=abort'}, seconds={'b2': 3.0})
    run = VirtualRun(line.cell, line.types)
    run.submit('J', line.script(with_section(2, '[{id: work, @a2}, {id: also, @b2}]')), 3)
    run.go()
    run.sim.clock.call_at(run.now + 40.0, lambda: None)
    run.go()
    run.answer('retry')
    run.go()
    assert run.ended
    return [event.stamped(event.seq, event.time + AT) for event in run.store.read()]


def journal_of(folder: Path, events: Sequence[Event]) -> str:
    folder.mkdir()
    with closing(SqliteStore(folder / 'cell.db')) as store:
        store.append(list(events))
    return str(folder / 'cell.db')


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(words) == 0
    return capsys.readouterr().out


# --- the Gantt chart ----------------------------------------------------------------------------


def bars(svg: str) -> list[dict[str, str]]:
    """Return all that is drawn of time, without its words."""
    return [dict(rect.attrib) for rect in ET.fromstring(svg).iter(f'{SVG}rect')]


def title(svg: str) -> str:
    return next(element.text or '' for element in ET.fromstring(svg).iter(f'{SVG}text'))


@either_way
@pytest.mark.parametrize('share', [30, 60])
@pytest.mark.parametrize('options', [(), ('--job', 'J')])
def test_chart_shows_elapsed_time_despite_clock_step(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    events: Sequence[Event],
    options: tuple[str, ...],
    share: int,
    by_s: float,
) -> None:
    def chart(folder: str, events: Sequence[Event]) -> str:
        journal = journal_of(tmp_path / folder, events)
        return printed(capsys, 'history', '--journal', journal, '--gantt', *options)

    as_it_was = chart('as it was', events)
    was_set = chart('set', stepped(events, [(share, by_s)]))
    assert bars(was_set) == bars(as_it_was)
    note = title(was_set).removeprefix(title(as_it_was))
    way = 'back' if by_s < 0 else 'forward'
    assert note.startswith(f'; the clock was set {way} by {abs(by_s):.0f} s at 1970-01-01 ')
    assert note.endswith('times go on as if it had not been set')


def test_chart_selection_follows_displayed_clock_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], events: Sequence[Event]
) -> None:
    def chart(*options: str) -> str:
        return printed(capsys, 'history', '--journal', journal, '--gantt', *options)

    journal = journal_of(tmp_path / 'set', stepped(events, [(50, 3600.0)]))
    whole = chart()
    (step,) = [item for item in stepped(events, [(50, 3600.0)]) if item.event == 'clock.stepped']
    after = str(datetime.fromtimestamp(step.time))
    before = str(datetime.fromtimestamp(step.time - 3600.0))
    drawn = [len(bars(item)) for item in (whole, chart('--to', before), chart('--from', after))]
    assert drawn[0] > max(drawn[1:])
    assert min(drawn[1:]) > 5
    skipped = datetime.fromtimestamp(step.time - 1800.0), datetime.fromtimestamp(step.time - 1700)
    words = ('--gantt', '--from', str(skipped[0]), '--to', str(skipped[1]))
    assert main(['history', '--journal', journal, *words]) == 1
    assert 'the clock skipped all of that time' in capsys.readouterr().err


# --- exports: of everything, and of one job, whose filter leaves the steps out -------------------

SELECTIONS = pytest.mark.parametrize('selection', [(), ('--job', 'J'), ('--event', 'task.')])


@either_way
@SELECTIONS
def test_process_mining_sees_the_time_that_passed(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    events: Sequence[Event],
    selection: tuple[str, ...],
    by_s: float,
) -> None:
    def log(folder: str, events: Sequence[Event]) -> list[tuple[str, datetime, datetime | None]]:
        journal = journal_of(tmp_path / folder, events)
        words = ('events', '--journal', journal, '--format', 'xes', *selection)
        return list(told(ET.fromstring(printed(capsys, *words))))

    def told(log: ET.Element) -> Iterator[tuple[str, datetime, datetime | None]]:
        for event in log.iter(f'{XES}event'):
            fields = {entry.get('key'): entry.get('value') or '' for entry in event}
            clock = fields.get('clock')
            time = datetime.fromisoformat(fields['time:timestamp'])
            name = fields['concept:name'] or ''
            yield name, time, datetime.fromisoformat(clock) if clock else None

    as_it_was, was_set = log('as it was', events), log('set', stepped(events, [(50, by_s)]))
    assert [entry[:2] for entry in was_set] == [entry[:2] for entry in as_it_was]
    clocks = [(clock - time).total_seconds() for _, time, clock in was_set if clock is not None]
    assert 3 < len(clocks) < len(was_set)
    assert set(clocks) == {by_s}


@either_way
@SELECTIONS
def test_tables_have_the_time_that_passed(
    tmp_path: Path, events: Sequence[Event], selection: tuple[str, ...], by_s: float
) -> None:
    parquet = pytest.importorskip('pyarrow.parquet')

    def seconds(folder: str, events: Sequence[Event]) -> list[float | None]:
        journal, to = journal_of(tmp_path / folder, events), tmp_path / f'{folder} tables'
        words = ['events', '--journal', journal, '--format', 'parquet', '-o', str(to)]
        assert main([*words, *selection]) == 0
        rows = parquet.read_table(to / 'tasks.parquet').to_pylist()
        return [row['seconds'] for row in rows]

    as_it_was = seconds('as it was', events)
    assert len(as_it_was) > 9
    assert all(as_it_was)
    flight = next(n for n, event in enumerate(events) if event.event == 'task.started') + 1
    in_flight = 100 * flight // len(events) + 1
    for number, share in enumerate((in_flight, 50)):
        was_set = seconds(f'set {number}', stepped(events, [(share, by_s)]))
        assert was_set == pytest.approx(as_it_was)


@pytest.mark.parametrize('selection', [(), ('--job', 'J')])
def test_tables_omit_attempt_duration_across_restart(
    tmp_path: Path, events: Sequence[Event], selection: tuple[str, ...]
) -> None:
    parquet = pytest.importorskip('pyarrow.parquet')
    begun = next(n for n, event in enumerate(events) if event.event == 'task.started') + 1
    node = OrchestratorStarted(cell='c', digest='d')
    lines = [*events[:begun], node.stamped(0, events[begun].time), *events[begun:]]
    journal = journal_of(
        tmp_path / 'restarted', [event.stamped(n, event.time) for n, event in enumerate(lines, 1)]
    )
    to = str(tmp_path / 'tables')
    words = ['events', '--journal', journal, '--format', 'parquet', '-o', to, *selection]
    assert main(words) == 0
    rows = parquet.read_table(f'{to}/tasks.parquet').to_pylist()
    assert [row['start_seq'] for row in rows if row['seconds'] is None] == [begun]
