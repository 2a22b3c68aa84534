"""An order from a client that cannot build structures."""

from __future__ import annotations

from cell_processes import run_verb, small_script
from opcua.conftest import StartLine

LAST = {'Simple/LastJob/ID': 'WO-1', 'Simple/LastJob/State': 'Ended', 'Simple/LastJob/Good': 2}


def test_an_order_runs_without_structures(start_line: StartLine) -> None:
    line = start_line()
    line.cell.script(small_script())
    client = line.client('mes')
    client.do('subscribe', values=list(LAST))
    refused = client.call('Simple', 'SubmitOrder', 'WO-1', 'smal', 2, [])['outputs']
    assert refused[0] is False
    assert 'smal' in refused[1] + ' '.join(refused[2])
    accepted, _, findings = client.call('Simple', 'SubmitOrder', 'WO-1', 'small', 2, [])['outputs']
    assert (accepted, findings) == (True, [])
    for node, value in LAST.items():
        client.wait_value(node, value)


def test_7_12_server_with_key_signs_for_its_users(start_line: StartLine) -> None:
    line = start_line(signs=True)
    line.cell.script(small_script())
    status, _, errors = run_verb(line.cell.folder, 'cell', 'pause', '--reason', 'a test')
    assert (status, 'has the role view (ros unauthenticated)' in errors) == (1, True), errors
    answer = line.client('mes').call('Simple', 'SubmitOrder', 'WO-1', 'small', 2, [])['outputs']
    assert answer[0] is True, answer
    decided = line.cell.watch.until('operator.decided', job='WO-1')
    expected = ('mes', 'mes', 'opc ua user')
    assert (decided['who'], decided['role'], decided['known']) == expected
    signature = line.cell.watch.until('request.signed')
    assert (signature['key'], signature['seq']) == ('opcua_1', decided['seq'] - 1)
    assert line.cell.watch.until_ended('WO-1').packed == 2
