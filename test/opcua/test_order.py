"""One job order from the order to its clearance, with node-opcua and an encrypted connection."""

from __future__ import annotations

from cell_processes import small_script
from opcua.conftest import StartLine
from opcua.line import EVENT, ORDERS, RECEIVER, RESULTS, job_order, parameter, state_of


def test_order_is_stored_run_reported_and_cleared(start_line: StartLine) -> None:
    line = start_line()
    line.cell.script(small_script())
    mes = line.client('mes')
    # Events come from every node that is watched, and the order of the sources is of no matter.
    mes.do('subscribe', values=[ORDERS], events={RESULTS: EVENT, RECEIVER: EVENT, 'i=2253': EVENT})
    customers = parameter('CustomerOrderNumbers', 'String', ['C-1', 'C-2'])
    order = job_order('WO-1', runs=3, parameters=[customers], description=[{'text': 'blue ones'}])
    assert mes.status('StoreAndStart', order) == 1
    mes.wait_state('WO-1', 'Ended')
    for source in (RESULTS, RECEIVER, 'i=2253'):
        mes.wait_told('WO-1', ['AllowedToStart', 'Running', 'Ended'], source)

    done = mes.call(RESULTS, 'RequestJobResponseByJobOrderID', 'WO-1')
    response, status = done['outputs']
    assert (done['status'], status) == ('Good', 1)
    assert (response['jobOrderID'], state_of(response['jobState'])) == ('WO-1', 'Ended')
    assert response['startTime'] < response['endTime']
    data = {entry['ID']: entry['value'] for entry in response['jobResponseData']}
    assert (data['GoodQuantity'], data['ScrapQuantity'], data['JobResult']) == (3, 0, 1)
    assert data['CustomerOrderNumbers'] == ['C-1', 'C-2']

    assert mes.status('Clear', 'WO-1') == 1
    mes.wait_state('WO-1', 'gone')
    assert mes.status('Clear', 'WO-1') == 2
    mes.do('close')
    line.server.stop()
