"""The verb `simulate`, without ROS 2."""

from __future__ import annotations

import argparse
import json
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, REFERENCE_ORDER, ROOT, STUCK, TREES

from bt_orchestrator.base.errors import JournalUnusable, Refused
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.simulating.verb import OrderFiles, add_arguments, simulate
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.sim.faults import with_faults
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.sqlite.store import SqliteStore

TYPES = FakeActionTypes()


def simulated(*words: str | Path) -> int:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    places = ['--cell', str(REFERENCE_CELL), '--trees', str(TREES)]
    return simulate(parser.parse_args([*map(str, words), *places]), TYPES)


def order(folder: Path, name: str, **keys: Any) -> Path:
    path = folder / f'{name}.yaml'
    path.write_text(''.join(f'{key}: {json.dumps(value)}\n' for key, value in keys.items()))
    return path


@pytest.fixture
def stuck(tmp_path: Path) -> Path:
    return order(tmp_path, 'stuck_order', script=str(STUCK), quantity=10)


def test_the_prediction_of_the_reference_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(REFERENCE_ORDER) == 0
    lines = [' '.join(line.split()) for line in capsys.readouterr().out.splitlines()]

    assert 'WO-1001 reference_process 3 3 6.5 s 39.0 s' in lines
    assert 'total time 39.0 s' in lines
    assert 'time per item 6.5 s in steady state' in lines
    slowest = 'bottleneck section 4, at best 6.5 s per item; section 2 is next, 1.5 s (23%) faster'
    assert slowest in lines
    assert 'pace 6.5 s per item, limited by 4.1 + 4.2 + 4.3 + 4.4 + index move' in lines
    assert 'Without 4.3 the pace would be 5.0 s per item, limited by 2.1 + index move.' in lines
    assert len(lines) == 8
    assert simulated(REFERENCE_ORDER, '--details') == 0
    assert 'conveyor 7 14.0 s 35.9%' in [
        ' '.join(line.split()) for line in capsys.readouterr().out.splitlines()
    ]


def test_the_prediction_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(REFERENCE_ORDER, '--json') == 0
    answer = json.loads(capsys.readouterr().out)

    assert (answer['ok'], answer['outcome'], answer['time_s']) == (True, 'finished', 39.0)
    assert (answer['bottleneck']['section'], answer['forecast']['per_item_s']) == (4, 6.5)
    assert answer['bottleneck'] == {
        'section': 4,
        'pace_s': 6.5,
        'next_section': 2,
        'margin_s': 1.5,
    }
    assert answer['forecast']['jobs'][0]['packed'] == 3
    assert [pace['per_item_s'] for pace in answer['paces']] == [6.5]


def test_a_mix_is_told_by_its_jobs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = order(tmp_path, 'other', order='WO-2', script='inspect_and_assemble', quantity=6)
    assert simulated(REFERENCE_ORDER, other) == 0
    lines = capsys.readouterr().out.splitlines()
    at = next(n for n, line in enumerate(lines) if line.startswith('time per item'))

    assert lines[at].endswith(' s in steady state, the mean of the mix')
    assert lines[at + 2].startswith('  WO-1001: 7.0 s; bottleneck section 4, at best 6.5 s')
    assert lines[at + 3].startswith('  WO-2: 8.5 s; bottleneck section 2, at best 5.0 s')
    paces = [line for line in lines if line.startswith('pace           of ')]
    assert paces[0].startswith(
        'pace           of reference_process: 6.5 s per item, limited by 4.1'
    )
    assert paces[1].startswith('pace           of inspect_and_assemble: 7.5 s per item or longer')


def test_stuck_line_says_what_sections_wait_for(
    stuck: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert simulated(stuck) == 1
    lines = capsys.readouterr().out.splitlines()

    assert lines[0] == 'stuck at 9.0 s:'
    assert '  section 2: waiting for assemble to take flag read_before_assemble' in lines
    assert not any(line.startswith('  section 5') for line in lines)


def test_a_stuck_line_as_json(stuck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(stuck, '--json') == 1
    answer = json.loads(capsys.readouterr().out)

    assert (answer['ok'], answer['outcome'], answer['time_s']) == (False, 'stuck', 9.0)
    idle = {'part': 'section 4', 'reason': 'waiting for an item', 'kind': 'item'}
    assert idle in answer['waits']


def test_a_hold_is_told_with_its_answers(capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(REFERENCE_ORDER, '--fail', 'component_1a.#2=abort') == 1
    lines = capsys.readouterr().out.splitlines()

    assert lines[:3] == [
        'held at 15.5 s:',
        (
            '  hold 1: section 2, 2.1 (TASK_A) of WO-1001/2 at component_1a (/component_1a/task), '
            'attempt 1 of 1: aborted (aborted by the simulated controller)'
        ),
        '    possible answers: retry, mark_done, skip, reject, abort_job',
    ]


def test_a_held_line_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(REFERENCE_ORDER, '--json', '--fail', 'conveyor.MOVE_ONE_INDEX=false') == 1
    (hold,) = json.loads(capsys.readouterr().out)['holds']

    assert (hold['task'], hold['section'], hold['item']) == ('index', None, None)
    assert hold['reason'] == 'task_result_false'


def test_trace_keeps_events_until_stuck_run_ends(stuck: Path, tmp_path: Path) -> None:
    trace = tmp_path / 'trace.jsonl'
    assert simulated(stuck, '--trace', trace) == 1
    events = [from_record(json.loads(line)) for line in trace.read_text().splitlines()]

    assert [event.seq for event in events] == list(range(1, len(events) + 1))
    assert events[-1].time == 9.0


def test_orders_run_in_sequence_with_free_ids(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nameless = {'script': 'reference_process', 'quantity': 1}
    orders = [
        order(tmp_path, 'first', **nameless),
        order(tmp_path, 'second', order='WO-1', **nameless),
        order(tmp_path, 'third', **nameless),
    ]
    assert simulated(*orders, '--json') == 0
    jobs = json.loads(capsys.readouterr().out)['forecast']['jobs']

    assert [job['job'] for job in jobs] == ['WO-2', 'WO-1', 'WO-3']
    ends = [job['finished_s'] for job in jobs]
    assert ends == sorted(ends)


def test_duplicate_order_id_is_refused_at_its_line(tmp_path: Path) -> None:
    again = order(tmp_path, 'again', script='reference_process', quantity=1, order='WO-1001')
    with pytest.raises(Refused) as refused:
        simulated(REFERENCE_ORDER, again)

    (finding,) = refused.value.findings
    assert (finding.file, finding.line, finding.column) == (str(again), 3, 8)
    assert f'`WO-1001` was given before, in {REFERENCE_ORDER}:2' in finding.what


def test_the_mistakes_of_all_orders_are_told(tmp_path: Path) -> None:
    wrong = order(tmp_path, 'wrong', script='reference_process', params={'lable': 'x'})
    nowhere = order(tmp_path, 'nowhere', script='referenc_process', quantity=1)
    with pytest.raises(Refused) as refused:
        simulated(wrong, nowhere, REFERENCE_ORDER)

    findings = [str(finding) for finding in refused.value.findings]
    assert len(findings) == 3
    assert 'names no quantity' in findings[0]
    assert 'did you mean `label`?' in findings[1]
    assert findings[2].startswith(f'{nowhere}:1:9: there is no script `referenc_process`')


def test_order_mistakes_hide_no_script_mistakes(tmp_path: Path) -> None:
    wrong = order(tmp_path, 'wrong', script='referenc_process', quantity=0)
    with pytest.raises(Refused) as refused:
        simulated(wrong)

    script, quantity = sorted(finding.what for finding in refused.value.findings)[::-1]
    assert script.startswith('there is no script `referenc_process`')
    assert quantity.startswith('`quantity` must be at least 1')


def test_conflicting_flags_are_refused_at_later_order(
    stuck: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = STUCK.read_text().replace('downstream: assemble}', 'downstream: assemble, capacity: 2}')
    script = tmp_path / 'wider.yaml'
    script.write_text(text.replace('script: stuck', 'script: wider'))
    wider = order(tmp_path, 'wider_order', script=str(script), quantity=1)

    assert simulated(stuck, wider, '--json') == 1
    answer = json.loads(capsys.readouterr().out)
    assert (answer['outcome'], answer['findings'][0]['file']) == ('refused', str(wider))
    assert 'share the flag read_before_assemble' in answer['findings'][0]['what']


@pytest.mark.parametrize(
    ('option', 'value', 'what'),
    [
        ('--fail', 'component_9=abort', 'no component `component_9`'),
        ('--trace', '/nowhere/at/all.jsonl', 'cannot write the trace'),
    ],
)
def test_options_that_cannot_be_had_are_wrong_use(option: str, value: str, what: str) -> None:
    with pytest.raises(WrongUse, match=what):
        simulated(REFERENCE_ORDER, option, value)


def test_chart_in_docs_matches_drawing(tmp_path: Path) -> None:
    chart = tmp_path / 'chart.svg'
    assert simulated(REFERENCE_ORDER, '--gantt', chart) == 0

    assert 'WO-1001/3' in chart.read_text(encoding='utf-8')
    shown = ROOT / 'docs' / 'simulate_reference.svg'
    assert chart.read_bytes() == shown.read_bytes(), 'see simulate.md for the command'


def test_chart_ends_where_stuck_run_stops(stuck: Path, tmp_path: Path) -> None:
    chart = tmp_path / 'chart.svg'
    assert simulated(stuck, '--gantt', chart) == 1

    assert '9 s in virtual time' in chart.read_text(encoding='utf-8')


def test_holds_are_answered_as_said(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    trace = tmp_path / 'trace.jsonl'
    fault = ['--fail', 'component_1a.#2=abort', '--on-hold', 'retry', '--answer-after', '7.5']
    assert simulated(REFERENCE_ORDER, *fault, '--trace', trace) == 0

    records = [json.loads(line) for line in trace.read_text().splitlines()]
    (decided,) = [record for record in records if record['event'] == 'operator.decided']
    (raised,) = [record for record in records if record['event'] == 'hold.raised']
    assert (decided['who'], decided['answer']) == ('simulate --on-hold', 'retry')
    assert decided['time'] - raised['time'] == 7.5


def test_answers_that_lead_nowhere_end_with_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(REFERENCE_ORDER, '--fail', 'component_1a.#*=abort', '--on-hold', 'retry') == 1

    assert 'was tried again 10 times and failed each time' in capsys.readouterr().out


@pytest.mark.parametrize('seconds', ['-1', 'soon', 'nan', 'inf'])
def test_a_time_to_answer_has_to_be_one(seconds: str) -> None:
    with pytest.raises(SystemExit):
        simulated(REFERENCE_ORDER, f'--answer-after={seconds}')


# --- what if ----------------------------------------------------------------------------------


@pytest.fixture
def quick_cell(tmp_path: Path) -> Path:
    path = tmp_path / 'quick.yaml'
    path.write_text(REFERENCE_CELL.read_text().replace('TASK_A: 1.0', 'TASK_A: 0.25'))
    return path


def test_another_cell_is_compared(quick_cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(REFERENCE_ORDER, '--what-if', quick_cell) == 0
    lines = [' '.join(line.split()) for line in capsys.readouterr().out.splitlines()]

    assert lines[0] == 'before after change'
    assert 'time per item 6.5 s 5.0 s -23.1 %' in lines
    assert 'section 2, an item every 5.0 s 5.0 s =' in lines
    assert 'bottleneck: from section 4 to section 2' in lines
    assert lines[-1] == 'after, pace: 5.0 s per item, limited by 2.1 + index move'


def test_another_script_is_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (TREES / 'reference_process.yaml').read_text()
    shorter = tmp_path / 'shorter.yaml'
    shorter.write_text(text.replace('    - {task: TASK_B, action: /component_3b/task}\n', ''))
    assert simulated(REFERENCE_ORDER, '--what-if', shorter, '--json') == 0

    answer = json.loads(capsys.readouterr().out)
    assert (answer['before']['time_s'], answer['after']['bottleneck']['section']) == (39.0, 2)
    changes = {change['what']: change for change in answer['changes']}
    assert changes['time per item']['percent'] == pytest.approx((5.0 / 6.5 - 1) * 100)


def test_a_what_if_that_gets_held_is_told(
    quick_cell: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fault = ['--fail', 'component_1a.#2=abort']
    assert simulated(REFERENCE_ORDER, '--what-if', quick_cell, *fault) == 1

    assert '  held at 15.5 s:' in capsys.readouterr().out.splitlines()


def test_a_file_that_is_neither_is_refused() -> None:
    with pytest.raises(
        Refused, match='this is a work order, and a cell file or a script is expected'
    ):
        simulated(REFERENCE_ORDER, '--what-if', REFERENCE_ORDER)


def test_ambiguous_script_replacement_is_wrong_use(tmp_path: Path) -> None:
    orders = [
        order(tmp_path, 'one', script='reference_process', quantity=1),
        order(tmp_path, 'two', script='inspect_and_assemble', quantity=1),
    ]
    text = (TREES / 'reference_process.yaml').read_text()
    other = tmp_path / 'other.yaml'
    other.write_text(text.replace('script: reference_process', 'script: other'))

    with pytest.raises(WrongUse, match='the orders ask for reference_process, inspect_and_assem'):
        simulated(*orders, '--what-if', other)


def test_two_runs_have_no_single_chart(quick_cell: Path) -> None:
    with pytest.raises(WrongUse, match='compares two runs'):
        simulated(REFERENCE_ORDER, '--what-if', quick_cell, '--gantt', 'x.svg')


@pytest.mark.parametrize(
    ('result', 'message'),
    [
        ('nothing.x=1', '--result is TASK.FIELD=VALUE, with a task of the scripts: '),
        ('inspect.mesurement=1', 'has no field `mesurement`'),
        ('inspect.measurement=high', '`measurement` must be a number'),
        ('inspect.measurement', 'a result is FIELD=VALUE'),
    ],
)
def test_unknown_task_result_is_wrong_use(tmp_path: Path, result: str, message: str) -> None:
    asked = order(tmp_path, 'order', script='inspect_and_assemble', quantity=1)
    with pytest.raises(WrongUse) as wrong:
        simulated(asked, '--on-hold', 'mark_done', '--result', result)
    assert message in str(wrong.value)


def test_order_start_is_counted_from_run_begin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start = {'start': '2026-05-18T06:00:00Z', 'due': '2026-05-18T07:00:00Z'}
    early = order(tmp_path, 'early', script='reference_process', quantity=3, **start)
    for begin, late_s in (('2026-05-18T05:50:00+00:00', 600.0), ('2026-05-18T06:10+00:00', 0.0)):
        assert simulated(early, '--json', '--begin', begin) == 0
        assert json.loads(capsys.readouterr().out)['time_s'] == pytest.approx(39.0 + late_s)


def test_a_journal_tells_what_is_likely(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = order(tmp_path, 'rework', script='rework_by_weight', quantity=30)
    journal = tmp_path / 'journal.sqlite3'
    cell, (given,) = OrderFiles([path], REFERENCE_CELL, [TREES], []).jobs(TYPES)
    faults = [f'component_3b.TASK_B#{n}=reads:9' for n in (2, 4, 7)]
    with closing(SqliteStore(journal, synchronous='NORMAL')) as store:
        run = Simulation(with_faults(cell, faults, TYPES), TYPES, store)
        run.submit([given.job])
        assert run.run() is Outcome.FINISHED
        run.close()

    assert simulated(path, '--journal', journal) == 0
    assert 'weigh fails 9.09 % of 33 attempts' in capsys.readouterr().out
    assert simulated(path, '--json') == 0
    (pace,) = json.loads(capsys.readouterr().out)['paces']
    assert pace['expected']['rates'][0]['of'] is None
    with pytest.raises(JournalUnusable):
        simulated(path, '--journal', tmp_path / 'none')
