"""What is said when the node does not count the role that the server asserts."""

from __future__ import annotations

import asyncio
from typing import cast

import pytest

from bt_orchestrator.extensions.opcua.server.calls import Caller, Calls, calling
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.events import OperatorDecided
from bt_orchestrator.ports.doors.tickets import Outcome, Tickets


class Answering:
    """Tickets of a node that always answers the same."""

    def __init__(self, claims: str) -> None:
        self._recorded = OperatorDecided(
            seq=7, time=0.0, answer='stop', who='ann', reason='why', role='view', claims=claims
        )

    async def carry_out(self, ticket: str, asked: object) -> Outcome:
        return Outcome(True, 'done', recorded=(self._recorded,))


@pytest.mark.parametrize('claims', ['operate (opc ua user)', ''])
def test_role_counted_as_claim_is_logged(caplog: pytest.LogCaptureFixture, claims: str) -> None:
    calls = Calls(cast(Tickets, Answering(claims)))
    with calling(Caller('ann', Role.OPERATE, 'a client at 10.0.0.1')):
        asyncio.run(calls.ask('cell.stop', {}, 'why'))
    assert ('it does not trust this OPC UA server' in caplog.text) is bool(claims)
    assert ('trust_local_doors' in caplog.text) is bool(claims)
