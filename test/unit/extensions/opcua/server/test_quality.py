"""What clients are told of the values while the node is silent, and after it came back another."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import asyncua
import pytest
from asyncua import ua
from opcua_reader import Reader, client_of, reading
from opcua_stand import opcua_stand
from patience import PATIENCE_S
from web.stand_cell import StandCell

from bt_orchestrator.model.jobs.order import WorkOrder

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

    async def until_all_are(self, code: int) -> None:
        """Wait until the last that was told of each value is of a quality.

        Only the newest value is told when a server is late, so each has to be waited for.
        """
        deadline = time.monotonic() + PATIENCE_S
        while any(self.codes(path)[-1:] != [code] for path in EVERYWHERE):
            assert time.monotonic() < deadline, self.told
            await asyncio.sleep(0.02)

    def codes(self, path: str) -> list[int]:
        """Return what was told of the quality of a value."""
        return [code for node_path, _, code in self.told if node_path == path]


@pytest.fixture(scope='module')
def line(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[StandCell, str]]:
    """One line for tests that make nothing on it; each leaves it switched on."""
    with opcua_stand(tmp_path_factory.mktemp('stand')) as (cell, server):
        yield cell, server.address


async def quality(reader: Reader, path: str) -> int:
    value = await reader.node(path).read_data_value(raise_on_bad_status=False)
    return int(value.StatusCode.value)


def test_silent_node_leaves_last_usable_values(
    line: tuple[StandCell, str],
) -> None:
    stand, url = line

    async def look(reader: Reader) -> None:
        heard = Heard()
        watch = await reader.client.create_subscription(50, heard)
        await watch.subscribe_data_change([reader.node(path) for path in EVERYWHERE])
        await heard.until_all_are(GOOD)
        assert [await quality(reader, path) for path in EVERYWHERE] == [GOOD] * 3
        before = await reader.node('Simple/State').read_data_value()
        await asyncio.to_thread(stand.switch)
        await reader.wait('Simple/Connected', lambda connected: connected is False)
        assert [await quality(reader, path) for path in EVERYWHERE] == [UNCERTAIN] * 3
        since = await reader.node('Simple/State').read_data_value(raise_on_bad_status=False)
        assert since.Value == before.Value
        assert since.SourceTimestamp == before.SourceTimestamp
        assert await quality(reader, 'Simple/Connected') == GOOD
        with pytest.raises(ua.uaerrors.BadNoCommunication):
            await reader.call('Simple/Command', 'cancel', 'WO-1', 'the node is off')
        await heard.until_all_are(UNCERTAIN)
        await asyncio.to_thread(stand.switch)
        await reader.wait('Simple/Connected', bool)
        assert [await quality(reader, path) for path in EVERYWHERE] == [GOOD] * 3
        await heard.until_all_are(GOOD)
        assert [heard.codes(path)[0] for path in EVERYWHERE] == [GOOD] * 3
        assert await reader.value('Simple/Connected') is True

    reading(url, look)


def test_another_journal_is_shown_as_it_is(tmp_path: Path) -> None:
    with opcua_stand(tmp_path) as (stand, server):

        async def look(reader: Reader) -> None:
            await asyncio.to_thread(stand.queue, WorkOrder(stand.script, 'WO-1', 1))
            await reader.wait('Simple/LastJob/ID', lambda value: value == 'WO-1')
            await asyncio.to_thread(stand.begin_anew, stand.cell)
            await reader.wait('Simple/LastJob/ID', lambda value: value == '')
            await asyncio.to_thread(stand.queue, WorkOrder(stand.script, 'WO-1', 2))
            await reader.wait('Simple/CurrentJob/Planned', lambda value: value == 2)

        reading(server.address, look)


def test_another_cell_file_makes_the_address_space_anew(line: tuple[StandCell, str]) -> None:
    """The port stays the same; clients lose their connection, and find the other cell."""
    stand, url = line
    reading(url, names_the_cell(stand.cell.name))
    other = replace(stand.cell, name=f'{stand.cell.name}_anew')
    stand.begin_anew(other)
    asyncio.run(until(url, lambda name: name == other.name))


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
            async with client_of(url) as client:
                if is_so(await name_of(await Reader.of(client))):
                    return
        await asyncio.sleep(0.1)
    raise AssertionError('the other cell is not shown')
