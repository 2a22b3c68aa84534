"""The server that uses nothing of asyncua's inside."""

from __future__ import annotations

import logging
import subprocess
import sys
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import pytest
from asyncua import ua
from fakes.opcua_access import with_login
from opcua_reader import Reader, reading
from opcua_stand import opcua_stand
from web.stand_cell import StandCell

from bt_orchestrator.extensions.opcua.server.overrides import services
from bt_orchestrator.model.jobs.order import WorkOrder

WHY = 'asyncua 9.9 has another inside'


@pytest.fixture(scope='module')
def plain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[StandCell, str]]:
    with opcua_stand(tmp_path_factory.mktemp('plain'), plain=WHY) as (cell, server):
        yield cell, server.address


def refused(what: Awaitable[object]) -> Callable[[], Awaitable[None]]:
    async def check() -> None:
        with pytest.raises(ua.UaStatusCodeError) as caught:
            await what
        assert caught.value.code == ua.StatusCodes.BadUserAccessDenied

    return check


def test_users_see_the_plain_values_as_they_change(plain: tuple[StandCell, str]) -> None:
    cell, url = plain

    async def see(reader: Reader) -> None:
        assert await reader.value('Simple/Connected') is True
        assert await reader.value('Simple/State') == 'Stopped'
        assert await reader.value('Simple/LastJob/ID') == ''
        assert cell.queue(WorkOrder(cell.script, 'WO-1', 1)).accepted
        await reader.wait('Simple/LastJob/ID', lambda value: value == 'WO-1')
        await reader.wait('Simple/State', lambda value: value == 'Complete')
        assert await reader.value('Simple/LastJob/State') == 'Ended'
        names = {browse_name.Name for browse_name in await names_below(reader, 'Simple')}
        assert {'State', 'CurrentJob'} <= names
        assert not names & {'SubmitOrder', 'Command', 'AnswerHold'}

    reading(url, see)


async def names_below(reader: Reader, path: str) -> list[ua.QualifiedName]:
    return [await child.read_browse_name() for child in await reader.node(path).get_children()]


def test_nobody_changes_anything(plain: tuple[StandCell, str]) -> None:
    async def try_to(reader: Reader) -> None:
        await refused(reader.node('Simple/State').write_value('Aborted'))()
        server = reader.client.nodes.server
        method = ua.NodeId(ua.ObjectIds.Server_GetMonitoredItems)
        await refused(server.call_method(method, ua.Variant(1, ua.VariantType.UInt32)))()
        await refused(reader.client.nodes.objects.add_object(1, 'mine'))()
        assert await reader.value('Simple/State') != 'Aborted'

    reading(plain[1], try_to)


@pytest.mark.parametrize(('name', 'password'), [('nobody', 'a guess'), ('engineer', 'a guess')])
def test_nobody_is_let_in_without_a_password(
    plain: tuple[StandCell, str], name: str, password: str
) -> None:
    url = with_login('opc.tcp://' + plain[1].rpartition('@')[2], name, password)
    with pytest.raises(ua.UaStatusCodeError) as caught:
        reading(url, lambda reader: reader.value('Simple/State'))
    assert caught.value.code == ua.StatusCodes.BadUserAccessDenied


def test_nobody_is_let_in_without_a_name(plain: tuple[StandCell, str]) -> None:
    with pytest.raises(ua.UaStatusCodeError):
        reading(
            'opc.tcp://' + plain[1].rpartition('@')[2],
            lambda reader: reader.value('Simple/State'),
        )


def test_it_is_said_once_why(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING), opcua_stand(tmp_path, plain=WHY):
        pass
    messages = [record.getMessage() for record in caplog.records if WHY in record.getMessage()]
    assert messages == [f'{WHY}; the server shows values, and takes no commands']


def test_what_changes_something_is_no_reading() -> None:
    named = {service for service in services.KNOWN if service not in services.READING}
    assert named == services._ids(('Write', 'HistoryRead', 'Call', 'TransferSubscriptions'))


def test_no_override_is_imported_for_it() -> None:
    """They might not fit: an unknown asyncua may have none of what they import."""
    program = (
        'import sys, bt_orchestrator.extensions.opcua.server.server;'
        'print(*(name for name in sys.modules if ".overrides." in name))'
    )
    modules = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, check=True
    ).stdout.split()
    overrides = 'bt_orchestrator.extensions.opcua.server.overrides.'
    assert set(modules) == {overrides + 'security', overrides + 'services'}
