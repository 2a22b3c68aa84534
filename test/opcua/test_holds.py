"""What waits for people, in the alarm list of node-opcua; and who may do what."""

from __future__ import annotations

import json
from typing import Any

import pytest
from cell_processes import small_script
from opcua.conftest import StartLine
from opcua.driver import Refused
from opcua.line import ORDERS, RECEIVER, Client, Line, job_order
from served_process import PASSWORD


def test_hold_raises_alarm_to_acknowledge_and_answer(start_line: StartLine) -> None:
    line = start_line(fail=['worker.#1=abort'])
    line.cell.script(small_script())
    operator = line.client('operate')
    fields = ['cell:Hold', 'cell:LastFeedback']
    operator.do('subscribe', values=[ORDERS], events={'i=2253': fields})
    assert operator.do('alarms') == []
    line.cell.run_small()
    hold = line.cell.watch.until_held()
    alarm = operator.wait(lambda news: news.get('news') == 'newAlarm', 'the alarm')['alarm']
    fields = alarm['fields']
    assert (fields['conditionName'], fields['sourceName']) == (f'Hold-{hold.id}', 'worker')
    assert (fields['activeState'], fields['ackedState']) == ('Active', 'Unacknowledged')
    assert 'WO-1/1' in fields['message']
    notification = operator.wait(
        lambda news: news.get('news') == 'event' and news['event']['Hold'] == hold.id, 'its fields'
    )
    assert json.loads(notification['event']['LastFeedback']) == json.loads(hold.last_feedback)
    assert hold.last_feedback

    assert operator.do('acknowledge', alarm=alarm['id'], comment='coming') == 'Good'
    _wait_changed(operator, 'ackedState', 'Acknowledged', 'coming')

    done = operator.call('Simple', 'AnswerHold', hold.id, 'retry', 'the gripper was open')
    assert (done['status'], done['outputs'][0]) == ('Good', True), done
    operator.wait_state('WO-1', 'Ended')
    _wait_changed(operator, 'activeState', 'Inactive', 'retry: the gripper was open')
    decided = line.cell.watch.until('operator.decided', hold=hold.id, answer='retry')
    assert (decided['who'], decided['known']) == ('operate', 'opc ua user')
    assert decided['reason'] == 'the gripper was open'


def _wait_changed(client: Client, name: str, value: str, comment: str) -> None:
    """Wait until a field of the alarm has changed, by this user."""
    alarm = client.wait(
        lambda news: news.get('news') == 'alarmChanged' and news['alarm']['fields'][name] == value,
        f'{name}: {value}',
    )
    fields = alarm['alarm']['fields']
    assert (fields['clientUserId'], fields['comment']) == ('operate', comment)


@pytest.mark.long
def test_who_has_no_right_starts_nothing(start_line: StartLine) -> None:
    line = start_line()
    line.cell.script(small_script())
    stranger = line.stranger('stranger')
    with pytest.raises(Refused):  # its certificate is not trusted
        stranger.do('connect', user='engineer', password=PASSWORD)
    line.server.trust(stranger.thumbprint)
    for login in ({}, {'user': 'mes', 'password': 'wrong'}, {'user': 'nobody', 'password': ''}):
        with pytest.raises(Refused):
            stranger.do('connect', **login)
    with pytest.raises(Refused):
        stranger.do('connect', isEncrypted=False, user='mes', password=PASSWORD)

    viewer = line.client('view')
    orders = {'Store': job_order('WO-1'), 'StoreAndStart': job_order('WO-1')}
    for method, what in {**orders, 'Start': 'WO-1', 'Abort': 'WO-1'}.items():
        done = viewer.call(RECEIVER, method, what, ['a test'])
        assert (method, done['status']) == (method, 'BadUserAccessDenied')
    simple = viewer.call('Simple', 'SubmitOrder', 'WO-1', 'small', 1, [])
    assert simple['status'] == 'BadUserAccessDenied'

    # An order that is allowed is the first that the node hears of.
    assert line.client('mes').status('StoreAndStart', job_order('WO-2')) == 1
    line.cell.watch.until_ended('WO-2')
    assert [event['job'] for event in line.cell.watch.seen('job.queued')] == ['WO-2']


def test_stops_get_plant_reasons_immediately_and_later(start_line: StartLine) -> None:
    line = start_line(fail=['worker.#1=abort'])
    line.cell.script(small_script())
    operator = line.client('operate')
    codes, groups, german = operator.read(
        *(f'Simple/Reasons/{n}' for n in ('Codes', 'Groups', 'de'))
    )
    assert dict(zip(codes, german, strict=True))['JAM'] == 'Materialstau'
    assert dict(zip(codes, groups, strict=True))['LUNCH'] == ''
    line.cell.run_small()
    hold = line.cell.watch.until_held()
    for method, given, code, word in (
        ('CommandWithCode', ('pause', ''), 'LUNCH', 'pause'),
        ('AnswerHoldWithCode', (hold.id, 'retry'), 'GRIPPER', 'retry'),
        ('ComponentCommandWithCode', ('out_of_service', 'worker'), 'CLEANING', 'out_of_service'),
    ):
        done = operator.call('Simple', method, *given, 'seen', code)
        assert (done['status'], done['outputs'][0]) == ('Good', True), done
        decided = line.cell.watch.until('operator.decided', answer=word)
        assert (decided['code'], decided['who']) == (code, 'operate')
    wrong = operator.call('Simple', 'AnswerHoldWithCode', hold.id, 'retry', 'seen', 'GRIPER')
    assert wrong['outputs'][0] is False

    stop = _stop_of(line, hold.id)
    assert stop['code'] == 'GRIPPER'
    done = operator.call('Simple', 'ClassifyStop', stop['stop'], 'SENSOR', 'looked again')
    assert done['outputs'][0] is True, done
    later = _stop_of(line, hold.id)
    assert (later['code'], later['by'], later['why']) == ('SENSOR', 'operate', 'looked again')


def _stop_of(line: Line, hold: str) -> dict[str, Any]:
    """Return the stop by a hold, as a report tells it."""
    status, output, errors = line.cell.verb('report', '--journal', str(line.journal), '--json')
    assert status == 0, errors
    stops = json.loads(output)['line_stops']
    stop: dict[str, Any] = next(entry for entry in stops if entry['hold'] == hold)
    return stop
