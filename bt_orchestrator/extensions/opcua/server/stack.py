"""The stack of OPC UA with the settings of this server."""

from __future__ import annotations

from datetime import datetime, timezone
from importlib.metadata import version

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.overrides.security import Security
from bt_orchestrator.extensions.opcua.server.overrides.server import GuardedServer

PRODUCT = 'urn:bt_orchestrator'


async def make_stack(node: str, security: Security, url: str) -> GuardedServer:
    """Return a server without a cell, which does not listen yet."""
    server = GuardedServer(security)
    server.product_uri = PRODUCT
    server.manufacturer_name = 'bt_orchestrator'
    server.set_server_name(f'bt_orchestrator {node}')
    server.application_type = ua.ApplicationType.Server
    await server.init()
    found = version('bt_orchestrator')
    now = datetime.now(timezone.utc)
    await server.set_build_info(PRODUCT, 'bt_orchestrator', 'bt_orchestrator', found, found, now)
    server.set_endpoint(url)
    return server
