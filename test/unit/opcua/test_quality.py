"""What clients are told of the values while the node is silent, and after it came back another."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import asyncua
import pytest
from asyncua import ua
from opcua_reader import Reader, reading
from opcua_stand import PATIENCE_S, opcua_stand

from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.store.memory import MemoryStore

UNCERTAIN, GOOD = ua.StatusCodes.UncertainLastUsableValue, ua.StatusCodes.Good

EVERYWHERE = ('Simple/State', 'Simple/CurrentJob/ID', 'Simple/OldestHold/Answers')


class Heard:
    """Keeps what a subscription tells."""

    def __init__(self) -> None:
        self.told: list[tuple[str, Any, int]] = []

    def datachange_notification(self, node: asyncua.Node, value: Any, data: Any) -> None:
        """Take note."""
        code = data.monitored_item.Value.StatusCode.value
        self.told.append((str(node.nodeid.Identifier), value, code))


async def quality(reader: Reader, path: str) -> int:
    found = await reader.node(path).read_data_value(raise_on_bad_status=False)
    return int(found.StatusCode.value)


def test_while_the_node_is_silent_values_are_the_last_usable_ones(tmp_path: Path) -> None:
    with opcua_stand(tmp_path) as (stand, server):

        async def look(reader: Reader) -> None:
            heard = Heard()
            watch = await reader.client.create_subscription(50, heard)
            await watch.subscribe_data_change([reader.node(path) for path in EVERYWHERE])
            assert [await quality(reader, path) for path in EVERYWHERE] == [GOOD] * 3
            before = await reader.node('Simple/State').read_data_value()
            await asyncio.to_thread(stand.switch)
            await reader.wait('Simple/Connected', lambda one: one is False)
            assert [await quality(reader, path) for path in EVERYWHERE] == [UNCERTAIN] * 3
            since = await reader.node('Simple/State').read_data_value(raise_on_bad_status=False)
            assert since.Value == before.Value
            assert since.SourceTimestamp == before.SourceTimestamp
            assert await quality(reader, 'Simple/Connected') == GOOD
            with pytest.raises(ua.uaerrors.BadNoCommunication):
                await reader.call('Simple/Command', 'cancel', 'WO-1', 'the node is off')
            await asyncio.to_thread(stand.switch)
            await reader.wait('Simple/Connected', bool)
            assert [await quality(reader, path) for path in EVERYWHERE] == [GOOD] * 3
            told = [(path, code) for path, _, code in heard.told]
            for path in EVERYWHERE:
                codes = [code for one, code in told if one == path]
                assert codes[0] == GOOD
                assert UNCERTAIN in codes
            assert await reader.value('Simple/Connected') is True

        reading(server.address, look)


def test_another_journal_is_shown_as_it_is(tmp_path: Path) -> None:
    with opcua_stand(tmp_path) as (stand, server):

        async def look(reader: Reader) -> None:
            await asyncio.to_thread(stand.queue, WorkOrder(stand.script, 'WO-1', 1))
            await reader.wait('Simple/LastJob/ID', lambda one: one == 'WO-1')

            def anew() -> None:
                with stand.lock:
                    stand.node.switch_off()
                    stand.store = MemoryStore()
                    stand.node.switch_on(stand.store)

            await asyncio.to_thread(anew)
            await reader.wait('Simple/LastJob/ID', lambda one: one == '')
            await asyncio.to_thread(stand.queue, WorkOrder(stand.script, 'WO-1', 2))
            await reader.wait('Simple/CurrentJob/Planned', lambda one: one == 2)

        reading(server.address, look)


def test_another_cell_file_makes_the_address_space_anew(tmp_path: Path) -> None:
    """The port stays the same; clients lose their connection, and find the other cell."""
    with opcua_stand(tmp_path) as (stand, server):
        reading(server.address, names_the_cell('reference_cell'))
        other = replace(stand.cell, name='other_cell')
        with stand.lock:
            stand.node.switch_off()
            stand.node.cell = stand.cell = other
            stand.node.switch_on(MemoryStore())
        asyncio.run(until(server.address, lambda name: name == other.name))


def names_the_cell(expected: str) -> Callable[[Reader], Any]:
    async def look(reader: Reader) -> None:
        assert await name_of(reader) == expected

    return look


async def name_of(reader: Reader) -> str:
    uri: str = (await reader.client.get_namespace_array())[reader.idx]
    return uri.rpartition(':')[2]


async def until(url: str, is_so: Callable[[str], bool]) -> None:
    """Connect again and again, as clients do, until the cell has the expected name."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        with contextlib.suppress(ConnectionError, asyncio.TimeoutError, ua.UaError):
            async with asyncua.Client(url) as client:
                if is_so(await name_of(await Reader.of(client))):
                    return
        await asyncio.sleep(0.1)
    raise AssertionError('the other cell is not shown')
