"""An order from a client that cannot build structures."""

from __future__ import annotations

from cell_processes import small_script
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
