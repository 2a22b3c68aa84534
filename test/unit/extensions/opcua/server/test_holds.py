"""Holds as conditions, as asyncua's own client gets them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from asyncua import ua
from fakes.operator import engineer
from opcua_events import Heard
from opcua_reader import Reader, reading
from opcua_stand import opcua_stand, served
from web.stand_cell import FAIL, StandCell

from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import ask
from bt_orchestrator.sim.virtual_link import VirtualLink
from bt_orchestrator.store.memory import MemoryStore

ACKNOWLEDGE = ua.NodeId(ua.ObjectIds.AcknowledgeableConditionType_Acknowledge)
ADD_COMMENT = ua.NodeId(ua.ObjectIds.ConditionType_AddComment)
TYPE = 'CellConditionType'


def order(cell: StandCell) -> None:
    assert cell.queue(WorkOrder(cell.script, 'WO-1', 4)).accepted


def answer(cell: StandCell, name: str, **given: Any) -> None:
    with cell.lock:
        link = VirtualLink(cell.node)
        try:
            reply = link.ask(ask(name, engineer('Ben', 'the shelf', 'it fits now'), **given))
        finally:
            link.close()
    assert reply.accepted, reply.message


def is_hold(event: Any) -> bool:
    return getattr(event, 'ConditionName', None) == 'Hold-1'


def is_over(event: Any) -> bool:
    return is_hold(event) and not getattr(event, 'ActiveState/Id')


async def say(reader: Reader, method: ua.NodeId, event: Any, words: str) -> None:
    condition = reader.client.get_node(event.NodeId)
    comment = ua.Variant(ua.LocalizedText(words), ua.VariantType.LocalizedText)
    id_ = ua.Variant(event.EventId, ua.VariantType.ByteString)
    await condition.call_method(method, id_, comment)


def test_a_hold_is_told_acknowledged_answered_and_over(tmp_path: Path) -> None:
    with opcua_stand(tmp_path, faults=[FAIL]) as (cell, server):

        async def look(reader: Reader) -> None:
            heard = await Heard.of(reader, own=TYPE)
            order(cell)
            hold = await heard.wait(is_hold)
            assert hold.EventType == reader.node(TYPE).nodeid
            assert hold.Message.Text.startswith('section 4, mark (TASK_A) of WO-1/3 at ')
            assert (hold.Severity, hold.SourceName, hold.Hold) == (600, 'component_3a', '1')
            assert hold.SourceNode == reader.node('Components/component_3a').nodeid
            assert 'retry' in hold.Answers
            assert hold.ControllerSaid == ''  # its Result has no text
            assert json.loads(hold.LastFeedback) == {'current_sub_task': 'TASK_A'}
            assert (hold.ReasonNumber, hold.Retain, hold.BranchId) == (203, True, ua.NodeId())
            assert getattr(hold, 'ActiveState/Id') is True
            assert getattr(hold, 'AckedState/Id') is False

            await say(reader, ADD_COMMENT, hold, 'who has the key?')
            remark = await heard.wait(lambda event: is_hold(event) and event.Comment.Text)
            assert (remark.Comment.Text, remark.ClientUserId) == ('who has the key?', 'stand')
            await say(reader, ACKNOWLEDGE, remark, 'on my way')
            seen = await heard.wait(
                lambda event: is_hold(event) and getattr(event, 'AckedState/Id')
            )
            assert seen.Comment.Text == 'on my way'
            with pytest.raises(ua.UaStatusCodeError, match='BadConditionBranchAlreadyAcked'):
                await say(reader, ACKNOWLEDGE, seen, 'again')
            seen.EventId = b'another one'
            with pytest.raises(ua.UaStatusCodeError, match='BadEventIdUnknown'):
                await say(reader, ADD_COMMENT, seen, 'of what?')

            answer(cell, 'hold.retry', hold='1')
            over = await heard.wait(is_over)
            assert (over.Retain, getattr(over, 'AckedState/Id')) == (False, True)
            assert over.Message.Text.startswith('over: Ben: retry: it fits now (section 4')
            with pytest.raises(ua.UaStatusCodeError, match='BadNodeIdUnknown'):
                await say(reader, ACKNOWLEDGE, over, 'late')
            refreshed = await heard.refresh(reader)
            assert not any(is_hold(event) for event in refreshed)

        reading(server.address, look)


def test_conditions_keep_ids_after_full_restart(tmp_path: Path) -> None:
    """Server and node are killed; the journal is there."""
    conditions: list[Any] = []

    async def look(reader: Reader) -> None:
        heard = await Heard.of(reader)
        (hold,) = [event for event in await heard.refresh(reader) if is_hold(event)]
        conditions.append((hold.EventId, hold.Comment.Text, getattr(hold, 'AckedState/Id')))

    async def acknowledge(reader: Reader) -> None:
        heard = await Heard.of(reader)
        order(cell)
        hold = await heard.wait(is_hold)
        await say(reader, ACKNOWLEDGE, hold, 'on my way')
        await heard.wait(lambda event: is_hold(event) and getattr(event, 'AckedState/Id'))

    with opcua_stand(tmp_path, faults=[FAIL], store=MemoryStore()) as (cell, server):
        reading(server.address, acknowledge)
        reading(server.address, look)
    cell.switch()
    cell.switch()
    with served(cell) as again:
        reading(again.address, look)
    assert conditions[0][1:] == ('on my way', True)
    assert conditions == conditions[:1] * 2


def test_general_type_filter_delivers_specific_alarms(tmp_path: Path) -> None:
    with opcua_stand(tmp_path, faults=[FAIL]) as (cell, server):

        async def look(reader: Reader) -> None:
            alarms, jobs = Heard(), Heard()
            for heard, kind in (
                (alarms, ua.ObjectIds.AcknowledgeableConditionType),
                (jobs, ua.ObjectIds.AuditEventType),
            ):
                subscription = await reader.client.create_subscription(20, heard)
                await subscription.subscribe_events(
                    reader.client.nodes.server,
                    evfilter=_of_type(kind),
                )
            order(cell)
            await alarms.wait(lambda _: True)
            assert jobs.events == []
            assert all('section 4' in event.Message.Text for event in alarms.events)

        reading(server.address, look)


def _of_type(kind: int) -> ua.EventFilter:
    message = ua.SimpleAttributeOperand(
        ua.NodeId(ua.ObjectIds.BaseEventType),
        [ua.QualifiedName('Message')],
        ua.AttributeIds.Value,
    )
    wanted = ua.LiteralOperand(Value=ua.Variant(ua.NodeId(kind), ua.VariantType.NodeId))
    element = ua.ContentFilterElement(ua.FilterOperator.OfType, [wanted])
    return ua.EventFilter([message], ua.ContentFilter([element]))
