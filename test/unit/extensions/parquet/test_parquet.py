"""The export as Parquet, read back with pyarrow and compared with the records."""

from __future__ import annotations

import json
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import pytest
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.view.report.csv_export import COLUMNS, LEFT_OUT

pa = pytest.importorskip('pyarrow', reason='needs pyarrow: ./scripts/bootstrap --parquet')
from pyarrow import parquet as pq  # noqa: E402

from bt_orchestrator.extensions.parquet import export as table_file  # noqa: E402
from bt_orchestrator.extensions.parquet.export import ParquetExport  # noqa: E402

STARTED = e.TaskStarted(
    job='J', section=2, item='J/1', task='work', name='TASK_A', action='/a2/do', component='a2',
    attempt=1, goal='g1',
)  # fmt: skip
SUCCEEDED = e.TaskSucceeded(job='J', section=2, item='J/1', task='work', attempt=1, goal='g1')


def a_run() -> VirtualRun:
    """Two items; the work fails once and is repeated, packing waits for a person."""
    text = with_section(2, '- {id: work, @a2, retries: 1}')
    return Line(faults={'a2': '#1=abort', 'a3': '#2=abort'}).run(text, 2)


def exported(folder: Path, texts: list[str]) -> tuple[Any, Any]:
    export = ParquetExport(folder, 'h-1')
    for text in texts:
        export.write(text)
    export.close()
    assert {path.name for path in folder.iterdir()} == {'events.parquet', 'tasks.parquet'}
    return pq.read_table(folder / 'events.parquet'), pq.read_table(folder / 'tasks.parquet')


def tables(folder: Path, *events: e.Event) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    stamped = [event.stamped(n, 10.0 * n) for n, event in enumerate(events, 1)]
    both = exported(folder, [to_text(event) for event in stamped])
    return both[0].to_pylist(), both[1].to_pylist()


def moment(seconds: float) -> datetime:
    return datetime.fromtimestamp(round(seconds * 1e6) / 1e6, timezone.utc)


def test_every_event_is_a_complete_typed_row(tmp_path: Path) -> None:
    records = a_run().records
    events, _ = exported(tmp_path, [json.dumps(record) for record in records])
    assert events.column_names == list(COLUMNS)
    kinds = {name: str(events.schema.field(name).type) for name in ('seq', 'time', 'results')}
    assert kinds == {'seq': 'int64', 'time': 'timestamp[us, tz=UTC]', 'results': 'string'}
    assert events.schema.metadata[b'bt_orchestrator.history'] == b'h-1'
    rows = events.to_pylist()
    assert len(rows) == len(records)
    for row, record in zip(rows, records, strict=True):
        stored = {name: value for name, value in row.items() if value is not None}
        stored |= json.loads(stored.pop('more', '{}'))
        stored['time'] = record['time'] if stored['time'] == moment(record['time']) else None
        for name in ('results', 'count'):
            if name in stored and not isinstance(record[name], int):
                stored[name] = json.loads(stored[name])
        assert stored == {k: v for k, v in record.items() if k not in LEFT_OUT}


def test_every_attempt_is_a_row(tmp_path: Path) -> None:
    run = a_run()
    records = run.records
    _, tasks = exported(tmp_path, [json.dumps(record) for record in records])
    rows = tasks.to_pylist()
    starts = {r['goal']: r for r in records if r['event'] == 'task.started'}
    ends = {r['goal']: r for r in records if r['event'] in ('task.succeeded', 'task.failed')}
    assert {row['goal'] for row in rows} == starts.keys()
    assert {row['outcome'] for row in rows} == {'succeeded', 'failed'}
    for row in rows:
        start, end = starts[row['goal']], ends[row['goal']]
        assert (row['started'], row['ended']) == (moment(start['time']), moment(end['time']))
        assert row['seconds'] == pytest.approx(end['time'] - start['time'], abs=1e-6)
        assert (row['start_seq'], row['end_seq']) == (start['seq'], end['seq'])
        assert row['outcome'] == end['event'].removeprefix('task.')
        assert row['reason'] == end.get('reason')
        for name in ('job', 'section', 'item', 'task', 'name', 'action', 'component', 'attempt'):
            assert row[name] == start.get(name)
        if row['outcome'] == 'succeeded':
            assert json.loads(row['results']) == end.get('results', {})


def test_numbers_that_json_or_64_bits_do_not_have(tmp_path: Path) -> None:
    args = {'big': 2**64 - 1, 'nan': float('nan'), 'inf': float('-inf'), 'small': 0.1}
    started = e.TaskStarted(**{**vars(STARTED), 'args': args, 'attempt': 2**70})
    events, tasks = tables(tmp_path, started)
    given = {'big': 2**64 - 1, 'nan': {'$float': 'nan'}, 'inf': {'$float': '-inf'}, 'small': 0.1}
    assert events[0]['attempt'] is None
    assert json.loads(events[0]['more']) == {'attempt': 2**70, 'args': given}
    assert tasks[0]['attempt'] is None
    assert json.loads(tasks[0]['arguments']) == given


def test_texts_of_devices(tmp_path: Path) -> None:
    text = '=1+1\x00\n\x1b[31m \ud800 ' + 'ä' * 100_000
    failed = e.TaskFailed(
        job='J', section=2, item='J/1', task='work', attempt=1, reason='aborted', message=text
    )
    events, tasks = tables(tmp_path, STARTED, failed)
    escaped = text.replace('\ud800', '\\ud800')
    assert events[1]['message'] == tasks[0]['message'] == escaped


def test_an_attempt_without_an_end_is_open(tmp_path: Path) -> None:
    again = e.TaskStarted(**{**vars(STARTED), 'goal': 'g2'})
    _, tasks = tables(tmp_path, STARTED, again)
    assert [(row['goal'], row['outcome'], row['ended']) for row in tasks] == [
        ('g1', 'open', None),
        ('g2', 'open', None),
    ]


def test_clock_step_does_not_change_attempt_duration(tmp_path: Path) -> None:
    step = e.ClockStepped(seconds=-5.0)  # the clock shows the times 10, 20 and 30
    _, tasks = tables(tmp_path, STARTED, step, SUCCEEDED)
    assert [(row['started'], row['ended'], row['seconds']) for row in tasks] == [
        (moment(10.0), moment(30.0), 25.0)
    ]


def test_what_was_not_measured_has_no_duration(tmp_path: Path) -> None:
    between = e.OrchestratorStarted(cell='c', digest='d')
    _, tasks = tables(tmp_path, STARTED, between, SUCCEEDED, STARTED, SUCCEEDED)
    assert [(row['outcome'], row['seconds']) for row in tasks] == [
        ('succeeded', None),
        ('succeeded', 10.0),
    ]


def test_memory_does_not_grow_with_the_events(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table_file, 'MOST_ROWS', 100)
    text = to_text(STARTED.stamped(1, 1.0))
    exported(tmp_path, [text] * 1050)
    meta = pq.ParquetFile(tmp_path / 'events.parquet').metadata
    groups = [meta.row_group(number).num_rows for number in range(meta.num_row_groups)]
    assert groups == [100] * 10 + [50]


def test_long_texts_make_shorter_row_groups(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table_file, 'MOST_CHARACTERS', 10_000)
    long = e.TaskStarted(**{**vars(STARTED), 'args': {'x': 'y' * 9_000}})
    exported(tmp_path, [to_text(long.stamped(1, 1.0))] * 6)
    assert pq.ParquetFile(tmp_path / 'tasks.parquet').metadata.num_row_groups >= 3


def test_discarded_export_keeps_earlier_tables(tmp_path: Path) -> None:
    exported(tmp_path, [to_text(STARTED.stamped(1, 1.0))])
    export = ParquetExport(tmp_path, 'h-1')
    export.write(to_text(SUCCEEDED.stamped(2, 2.0)))
    export.discard()
    assert {path.name for path in tmp_path.iterdir()} == {'events.parquet', 'tasks.parquet'}
    assert pq.read_table(tmp_path / 'events.parquet')['seq'].to_pylist() == [1]
