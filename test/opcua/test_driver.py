"""node-opcua at a server that is asyncua as it comes: what fails here is no fault of ours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import pytest
from asyncua import ua
from asyncua.common.methods import uamethod
from asyncua.sync import Server, SyncNode
from held_port import HeldPort
from opcua.conftest import StartDriver

URI = 'urn:bt_orchestrator:test'


@uamethod  # type: ignore[untyped-decorator]
def add(parent: ua.NodeId, first: int, other: int) -> int:
    return first + other


@pytest.fixture
def plain() -> Iterator[tuple[str, SyncNode]]:
    """Give the endpoint of a server, and its one variable."""
    server, port = Server(), HeldPort()
    endpoint = f'opc.tcp://127.0.0.1:{port.number}'
    server.set_endpoint(endpoint)
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    index = server.register_namespace(URI)

    def node(path: str) -> ua.NodeId:
        return ua.NodeId.from_string(f'ns={index};s={path}')

    cell = server.nodes.objects.add_object(node('Cell'), 'Cell')
    number = cell.add_variable(node('Cell/Number'), 'Number', 3)
    long = ua.VariantType.Int64
    cell.add_method(node('Cell/Add'), 'Add', add, [long, long], [long])
    with closing(port), server:
        yield endpoint, number


def test_it_reads_calls_and_subscribes(
    plain: tuple[str, SyncNode], start_driver: StartDriver
) -> None:
    endpoint, number = plain
    client = start_driver(endpoint, URI)
    client.do('connect', isEncrypted=False)
    assert client.read('Cell/Number') == [3]
    assert client.call('Cell', 'Add', 2**33, 4) == {'status': 'Good', 'outputs': [2**33 + 4]}
    client.do('subscribe', values=['Cell/Number'])
    client.wait_until(lambda: client.values('Cell/Number') == [3], 'the value of now')
    number.write_value(4)
    client.wait_until(lambda: client.values('Cell/Number') == [3, 4], 'the new value')
    assert client.do('counted')['CreateSubscriptionRequest'] == 1
    client.do('close')
