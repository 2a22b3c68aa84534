"""Events of job control: a job has another state, and why a call was refused."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence

from asyncua import ua

from bt_orchestrator.extensions.opcua.mes.followed_jobs import News
from bt_orchestrator.extensions.opcua.server.calls import Argument
from bt_orchestrator.extensions.opcua.server.job_control.structures import Structures
from bt_orchestrator.extensions.opcua.server.notices import Told, id_of
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.view.report.isa95.codes import ReturnStatus
from bt_orchestrator.view.report.isa95.job_order import job_order
from bt_orchestrator.view.report.isa95.job_response import response_of

CHANGED, REFUSED = 'JobOrderChangedEventType', 'RequestRefusedEventType'

_STATUS_EVENT = 1006
"""ISA95JobOrderStatusEventType, which is abstract."""

_ORDINARY, _NOTABLE = 100, 300
"""Severities."""


class StatusEvents:
    """Tells them at results and receiver, at the cell and at the Server object."""

    def __init__(self, space: Space, structures: Structures, *nodes: ua.NodeId) -> None:
        """Prepare.

        :param nodes: results, and receiver
        """
        self._space = space
        self._structures = structures
        self._results, self._receiver = nodes
        self._numbers = itertools.count(1)

    async def build(self, namespace: int) -> None:
        """Make the types of the events.

        :param namespace: of the nodeset
        """
        space, text = self._space, ua.VariantType.String
        base = ua.NodeId(_STATUS_EVENT, namespace)
        self._changed = (
            await space.event_type(CHANGED, base, (), 'a job order has another state')
        ).nodeid
        refused = (
            Argument('Method', text, 'that was called'),
            Argument('JobOrderID', text, 'that it was about'),
            Argument('ReturnStatus', ua.VariantType.UInt64, 'that it answered'),
            Argument('Findings', text, 'every mistake found', is_list=True),
        )
        base = ua.NodeId(ua.ObjectIds.BaseEventType)
        self._refused = (
            await space.event_type(REFUSED, base, refused, 'a call was refused, and why')
        ).nodeid

    def tell(self, news: News, history: str) -> None:
        """Tell that a job has another state, with the job as it was at this record."""
        structures, status = self._structures, news.job.status
        response = response_of(news.job, news.interrupted)
        kind = ua.VariantType.ExtensionObject
        self._space.notices.tell(
            Told(
                type_id=self._changed,
                id=id_of(history, news.seq, status.id),
                source=self._results,
                source_name='JobOrderResults',
                time=news.time,
                message=f'{status.id} {_what(news)}',
                severity=_NOTABLE if status.state in _NOTABLE_STATES else _ORDINARY,
                fields={
                    'JobOrder': ua.Variant(structures.order(job_order(news.job)), kind),
                    'JobState': ua.Variant(structures.states(response.states), kind),
                    'JobResponse': ua.Variant(structures.response(response), kind),
                },
            ),
            self._results,
            self._receiver,
        )

    def tell_refusal(
        self, method: str, job: str, status: ReturnStatus, message: str, findings: Sequence[str]
    ) -> None:
        """Tell why a call was refused: ReturnStatus has no text."""
        text = ua.VariantType.String
        now = time.time()
        self._space.notices.tell(
            Told(
                type_id=self._refused,
                id=id_of('refused', now, method, job, next(self._numbers)),
                source=self._receiver,
                source_name='JobOrderControl',
                time=now,
                message=f'{method} {job}: {message}',
                severity=_NOTABLE,
                fields={
                    'Method': ua.Variant(method, text),
                    'JobOrderID': ua.Variant(job, text),
                    'ReturnStatus': ua.Variant(int(status), ua.VariantType.UInt64),
                    'Findings': ua.Variant(list(findings), text, is_array=True),
                },
            ),
            self._receiver,
        )


def _what(news: News) -> str:
    state = news.job.status.state
    if news.remark:
        return news.remark
    return f'is {state.value}' + ('' if news.before is None else f', was {news.before.value}')


_NOTABLE_STATES = (JobWord.HELD, JobWord.ABORTED)
