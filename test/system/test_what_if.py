"""`what-if`: when jobs would end after some requests, asked of a line at work."""

from __future__ import annotations

import json
import shlex

from cell_processes import CellProcesses, StartCell, small_script


def order_file(cell: CellProcesses, name: str, quantity: int) -> str:
    path = cell.folder / f'{name}.order.yaml'
    path.write_text(f'{{order: {name}, script: small, quantity: {quantity}}}')
    return str(path)


def test_requests_are_worked_out_and_not_made(start_cell: StartCell) -> None:
    cell = start_cell(speed=4)  # 500 items take minutes: the job is there to the end
    cell.connect()
    cell.script(small_script())
    cell.run_small(quantity=500, order='long')
    cell.watch.until('item.removed')
    orders = [order_file(cell, name, 20) for name in 'ab']
    assert cell.verb('submit', *orders)[0] == 0

    status, output, errors = cell.verb('what-if', 'job next b', '--json')
    assert status == 0, errors
    prediction = json.loads(output)
    before = {entry['job']: entry['ends_s'] for entry in prediction['before']}
    after = {entry['job']: entry['ends_s'] for entry in prediction['after']}
    assert list(before) == ['long', 'a', 'b']
    assert list(after) == ['long', 'b', 'a']
    assert before['a'] < before['b']
    assert after['b'] < after['a']

    trees = ('--trees', str(cell.folder))
    rush = order_file(cell, 'rush', 1)
    words = (f'submit {rush}', 'queue next rush', 'queue resume long')
    status, output, errors = cell.verb('what-if', *words, *trees)
    assert status == 1, errors
    lines = output.splitlines()
    assert lines[0].split() == ['job', 'ends', 'in', 'would', 'end', 'in', 'change']
    assert [line.split()[0] for line in lines[1:5]] == ['long', 'rush', 'a', 'b']
    assert lines[2].split()[1] == 'new'
    assert lines[5].startswith('would be refused: job.resume: long is Running; ')

    status, output, _ = cell.verb('queue', '--json')
    assert [job['id'] for job in json.loads(output)['jobs']] == ['long', 'a', 'b'], 'as before'
    status, _, errors = cell.verb('what-if', 'status')
    assert (status, 'asks nothing of the cell' in errors) == (2, True)


def test_proposed_order_applies_only_to_unchanged_queue(start_cell: StartCell) -> None:
    cell = start_cell(speed=4)
    cell.connect()
    cell.script(small_script())
    cell.run_small(quantity=500, order='long')
    cell.watch.until('item.removed')
    orders = [order_file(cell, name, 20) for name in 'ab']
    assert cell.verb('submit', *orders)[0] == 0
    due = ('--due', '2020-01-01T00:00:00Z', '--quantity', '2', '--reason', 'promised')
    assert cell.verb('job', 'update', 'b', *due)[0] == 0

    status, output, errors = cell.verb('queue', 'propose')
    assert status == 0, errors
    *_, sure, apply = output.splitlines()
    assert sure.startswith('it is the best of all 2 orders')
    _, _, request = apply.partition('to apply it: bt-orchestrator ')
    words = shlex.split(request)
    assert words[-4:-2] == ['b', 'a']

    assert cell.verb('job', 'hold', 'a', '--reason', 'no material')[0] == 0
    status, _, errors = cell.verb(*words)
    assert (status, 'the queue has changed since' in errors) == (1, True)
    assert cell.verb('job', 'release', 'a', '--reason', 'it came')[0] == 0
    status, output, errors = cell.verb('queue', 'propose', '--apply', '--reason', 'promised')
    assert status == 0, errors
    assert output.splitlines()[-1] == 'the order of the queue is b, a'
    status, output, _ = cell.verb('queue', '--json')
    assert [job['id'] for job in json.loads(output)['jobs']] == ['long', 'b', 'a']
    status, output, _ = cell.verb('queue', 'propose')
    assert (status, 'the queue stays unchanged' in output) == (0, True)
