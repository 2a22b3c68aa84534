"""The items of a job as a table for spreadsheets."""

from __future__ import annotations

import csv
from dataclasses import replace
from io import StringIO

from bt_orchestrator.model.jobs.job_record import FailureRecord, ItemRecord, JobRecord
from bt_orchestrator.view.report.csv_export import ITEM_COLUMNS, write_items


def rows(job: JobRecord) -> list[dict[str, str]]:
    file = StringIO(newline='')
    write_items(job, file)
    return list(csv.DictReader(StringIO(file.getvalue(), newline='')))


def job(*items: ItemRecord, failures: tuple[FailureRecord, ...] = ()) -> JobRecord:
    named = {item.item: item for item in items}
    record = JobRecord('WO-1', 'boxes', 2, 0.0, recipe='WM-100', recipe_version=3)
    return replace(record, items=named, failures=list(failures))


def test_item_row_has_end_and_duration() -> None:
    bad = ItemRecord('WO-1/1', 10.0, 12.5, 'rejected', ['weigh', 'seal'], {'glue': 2})
    failed = FailureRecord(11.0, 'weigh', 1, 'aborted', item='WO-1/1')
    first, second = rows(job(bad, ItemRecord('WO-1/2', 11.0), failures=(failed,)))
    assert tuple(first) == ITEM_COLUMNS
    assert (first['item'], first['how'], first['seconds']) == ('WO-1/1', 'rejected', '2.5')
    assert first['started'] == '1970-01-01T00:00:10.000000+00:00'
    assert (first['nonconforming'], first['failures']) == ('weigh seal', '1')
    assert (second['how'], second['ended'], second['seconds']) == ('', '', '')
    assert second['failures'] == '0'
    assert (first['rounds'], second['rounds']) == ('2', '0')
    assert (first['recipe'], first['recipe_version']) == ('WM-100', '3')


def test_each_result_has_column_named_like_reference() -> None:
    item = ItemRecord('WO-1/1', 1.0, results={'weigh': {'grams': 5.5}, 'read': {'code': 'A'}})
    other = ItemRecord('WO-1/2', 2.0, results={'weigh': {'grams': 6.0, 'raw': [1, 2]}})
    first, second = rows(job(item, other))
    assert tuple(first)[len(ITEM_COLUMNS) :] == (
        'results.weigh.grams',
        'results.read.code',
        'results.weigh.raw',
    )
    assert (first['results.weigh.grams'], first['results.read.code']) == ('5.5', 'A')
    assert (second['results.read.code'], second['results.weigh.raw']) == ('', '[1, 2]')


def test_a_text_of_a_device_is_no_formula() -> None:
    read = ItemRecord('WO-1/1', 1.0, results={'read': {'code': '=1+1'}})
    (row,) = rows(job(read))
    assert row['results.read.code'] == "'=1+1"
