"""The stack of OPC UA as it is set up here."""

from __future__ import annotations

import platform
from datetime import datetime, timezone
from importlib.metadata import version

import asyncua
from asyncua import ua

from bt_orchestrator.opcua.access import Access

PRODUCT = 'urn:bt_orchestrator'


def application_uri(node: str) -> str:
    """Return the URI of the server of one node on this computer; its certificate has it, too."""
    return f'{PRODUCT}:{platform.node()}:{node.strip("/").replace("/", ":")}'


async def make_stack(node: str, access: Access, url: str) -> asyncua.Server:
    """Return a server without a cell, which does not listen yet."""
    server = asyncua.Server()
    server.product_uri = PRODUCT
    server.manufacturer_name = 'bt_orchestrator'
    server.set_server_name(f'bt_orchestrator {node}')
    server.application_type = ua.ApplicationType.Server
    await server.init()
    await server.set_application_uri(application_uri(node))
    found = version('bt_orchestrator')
    now = datetime.now(timezone.utc)
    await server.set_build_info(PRODUCT, 'bt_orchestrator', 'bt_orchestrator', found, found, now)
    server.set_endpoint(url)
    if access.local_user:
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        server.set_identity_tokens([ua.AnonymousIdentityToken])
    return server
