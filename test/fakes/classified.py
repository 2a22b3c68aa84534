"""Runs in which operators gave reasons for stops, at once and later."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random
from typing import Any

from fakes.naive_account import naive_stops

from bt_orchestrator.model.requests import is_remark
from bt_orchestrator.view.report.account.planned import us_of

BY_HAND = ('pause', 'stop', 'abort', 'out_of_service')


def with_codes(records: Sequence[Mapping[str, Any]], random: Random) -> list[dict[str, Any]]:
    """Return a run whose decisions have reasons, some of them, and stops that get one later."""
    run = [dict(record) for record in records]
    for record in run:
        may_have = record['event'] == 'operator.decided' and (
            record['answer'] in BY_HAND or ('hold' in record and not is_remark(record['answer']))
        )
        if may_have and random.random() < 0.6:
            record['code'] = random.choice('ABC')
    stops = naive_stops(run, [(us_of(run[0]['time']), us_of(run[-1]['time']) + 1)])
    for stop in random.choices(stops, k=len(stops)) if stops else ():
        last = run[-1]
        answer = {'answer': 'classify', 'who': 'ann', 'reason': '', 'code': random.choice('ABC')}
        place = {'seq': last['seq'] + 1, 'time': last['time'], 'event': 'operator.decided'}
        run.append({**place, **answer, 'stop': f'x:{stop.seq}'})
    return run
