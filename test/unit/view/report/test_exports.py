"""Exports: what other programs read, checked as they would."""

from __future__ import annotations

import csv
import io
import json
import re
import xml.etree.ElementTree as ET
from datetime import datetime

import pytest
from fakes.line import Line, with_section
from fakes.virtual_run import VirtualRun

from bt_orchestrator.view.report.csv_export import COLUMNS, LEFT_OUT, CsvExport
from bt_orchestrator.view.report.xes_export import XesExport

XES = '{http://www.xes-standard.org/}'
KINDS = ('string', 'date', 'int', 'float', 'boolean', 'id')
LOG_ORDER = ('extension', 'global', 'classifier', 'attribute', 'trace')
STANDARD = (
    *('schedule', 'assign', 'withdraw', 'reassign', 'start', 'suspend', 'resume', 'pi_abort'),
    *('ate_abort', 'complete', 'autoskip', 'manualskip', 'unknown'),
)


def a_run() -> VirtualRun:
    look = '- {id: look, @b2, when: {value: "${order.id}", equals: other}}'
    text = with_section(2, f'- {{id: work, @a2, retries: 1}}\n{look}')
    run = Line(faults={'a2': '#1=abort', 'a3': '#2=abort'}).run(text, 2)
    run.answer('mark_done')
    return run.go()


def exported(kind: type[CsvExport] | type[XesExport], records: list[dict[str, object]]) -> str:
    file = io.StringIO()
    export = kind(file)
    for record in records:
        export.write(json.dumps(record, ensure_ascii=False))
    export.close()
    return file.getvalue()


def log_of(records: list[dict[str, object]]) -> ET.Element:
    return ET.fromstring(exported(XesExport, records))


def values(element: ET.Element) -> dict[str, str]:
    return {a.attrib['key']: a.attrib['value'] for a in element if 'key' in a.attrib}


# --- XES --------------------------------------------------------------------------------------


def test_a_log_has_the_structure_of_the_standard() -> None:
    log = log_of(a_run().records)
    assert log.tag == f'{XES}log'
    assert re.fullmatch(r'\d+\.\d+', log.attrib['xes.version'])
    kinds = [child.tag.removeprefix(XES) for child in log]
    order = [LOG_ORDER.index('attribute' if kind in KINDS else kind) for kind in kinds]
    assert order == sorted(order)
    named = (*log.iter(f'{XES}extension'), *log.iter(f'{XES}classifier'))
    assert all(re.fullmatch(r'\w+', element.attrib['name']) for element in named)  # NCName
    prefixes = {e.attrib['prefix'] for e in log.iter(f'{XES}extension')}
    assert prefixes == {'concept', 'lifecycle', 'time', 'org'}
    for element in log.iter():
        if element.tag.removeprefix(XES) in KINDS:
            assert element.attrib.keys() == {'key', 'value'}
            if not element.tag.endswith('string'):
                (int if element.tag.endswith('int') else datetime.fromisoformat)(
                    element.attrib['value']
                )


def test_traces_and_events_have_declared_attributes() -> None:
    log = log_of(a_run().records)
    globals_ = {g.attrib['scope']: set(values(g)) for g in log.iter(f'{XES}global')}
    traces = log.findall(f'{XES}trace')
    assert len(traces) == 2
    for trace in traces:
        assert globals_['trace'] <= values(trace).keys()
        for event in trace.findall(f'{XES}event'):
            assert globals_['event'] <= values(event).keys()
            assert values(event)['lifecycle:transition'] in STANDARD


def test_an_item_is_a_trace_of_its_tasks() -> None:
    first, second = log_of(a_run().records).findall(f'{XES}trace')
    assert values(first) == {
        'concept:name': 'J/1',
        'job': 'J',
        'script': 'test',
        'outcome': 'packed',
    }
    events = [values(event) for event in first.findall(f'{XES}event')]
    assert [(e['concept:name'], e['lifecycle:transition']) for e in events] == [
        ('place', 'start'),
        ('place', 'complete'),
        ('work', 'start'),
        ('work', 'ate_abort'),
        ('work', 'schedule'),
        ('work', 'start'),
        ('work', 'complete'),
        ('look', 'autoskip'),
        ('pack', 'start'),
        ('pack', 'complete'),
    ]
    starts = [e for e in events if e['lifecycle:transition'] == 'start']
    assert {e['org:resource'] for e in starts} == {'a1', 'a2', 'a3'}
    assert len({e['concept:instance'] for e in starts}) == 4
    assert events[3]['org:resource'] == 'a2'
    assert values(second.findall(f'{XES}event')[-1])['lifecycle:transition'] == 'complete'


def test_an_operators_skip_is_told_from_the_scripts() -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    run.answer('skip')
    trace = log_of(run.go().records).find(f'{XES}trace')
    assert trace is not None
    moves = [values(e)['lifecycle:transition'] for e in trace.findall(f'{XES}event')]
    assert 'manualskip' in moves


def test_what_a_device_says_cannot_break_the_log() -> None:
    record = {
        'seq': 1,
        'time': 0.5,
        'event': 'task.failed',
        'job': 'J',
        'section': 1,
        'item': 'J/1',
        'task': 'a "b" <c>',
        'attempt': 1,
        'reason': 'aborted',
        'message': 'bell \x07 & \ud83d\ude00'.encode('utf-16', 'surrogatepass').decode('utf-16'),
    }
    (event,) = log_of([record]).iter(f'{XES}event')
    assert values(event)['concept:name'] == 'a "b" <c>'
    assert values(event)['message'] == 'bell \N{REPLACEMENT CHARACTER} & \U0001f600'


# --- CSV --------------------------------------------------------------------------------------


def rows_of(records: list[dict[str, object]]) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(exported(CsvExport, records), newline='')))


def test_one_row_an_event_under_the_same_columns() -> None:
    records = a_run().records
    rows = rows_of(records)
    assert len(rows) == len(records)
    for row, record in zip(rows, records, strict=True):
        assert tuple(row) == COLUMNS
        assert row['seq'] == str(record['seq'])
        assert datetime.fromisoformat(row['time']).timestamp() == record['time']
        known = {k: v for k, v in record.items() if k in COLUMNS and k not in ('seq', 'time')}
        assert {name: row[name] for name in known if not isinstance(known[name], dict)} == {
            k: str(v) for k, v in known.items() if not isinstance(v, dict)
        }
        left = record.keys() - set(COLUMNS) - set(LEFT_OUT)
        assert (json.loads(row['more']) if row['more'] else {}).keys() == left


@pytest.mark.parametrize('delimiter', [',', ';', '\t'])
def test_text_becomes_no_formula_with_any_delimiter(delimiter: str) -> None:
    texts = [
        *('=1+1', '+1', '-1+1', '@SUM(1)', '\t=1', '\r=1', 'a;=1+1', 'a;"=1+1"', 'a\n=1+1'),
        *('a\r\n=1', 'a\t=1+1', 'a\t-1', 'a";=1+1', ';;@A1', 'a;=HYPERLINK("http://x")'),
    ]
    records: list[dict[str, object]] = [
        {'seq': 1, 'time': 0.0, 'event': 'x', 'message': text, 'more_of_it': text}
        for text in texts
    ]
    lines = exported(CsvExport, records).splitlines(keepends=True)
    for row in csv.reader(lines, delimiter=delimiter):
        assert not [cell for cell in row if cell.startswith(('=', '+', '-', '@'))], row


def test_texts_stay_in_their_cell() -> None:
    message = 'a "quoted", odd\nmessage'
    odd = {'seq': 1, 'time': 0.0, 'event': 'task.failed', 'message': message, 'name': '=1+1'}
    (row,) = rows_of([odd])
    assert row['message'] == message
    assert row['name'] == "'=1+1"
