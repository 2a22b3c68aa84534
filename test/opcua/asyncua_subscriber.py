"""A client of asyncua that subscribes, connects again by itself, and remembers what came."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from asyncua import Client, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256
from cryptography.x509.oid import ExtendedKeyUsageOID
from opcua.line import NAMESPACE, ORDERS, RESULTS, state_of
from patience import PATIENCE_S
from served_process import PASSWORD

JOB_CONTROL = 'http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/'

_BUSY_S = 20.0
"""A server on a busy machine may take so long for an answer."""


class AsyncuaSubscriber:
    """Runs in a thread of its own. States: made, connected (after `connect`), ended (`close`).

    :ivar told: event id, job order and state of each event, in order
    :ivar lists: the job orders of each JobOrderList, in order
    """

    def __init__(self, folder: Path, endpoint: str) -> None:
        self.told: list[tuple[bytes, str, str]] = []
        self.lists: list[list[str]] = []
        self._folder = folder / 'asyncua_pki'
        self._folder.mkdir()
        self._endpoint = endpoint
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._do(self._make_certificate())

    def connect(self, user: str, trust: Callable[[str], object]) -> None:
        """Connect and subscribe.

        :param trust: has the server trust a thumbprint, which it refuses the first time
        """
        with contextlib.suppress(ua.UaError, OSError, asyncio.TimeoutError):
            self._do(self._connect(user))
            return
        trust(self._thumbprint)
        self._do(self._connect(user))

    def close(self) -> None:
        """Leave, whatever the server does."""
        if hasattr(self, '_client'):
            self._do(self._disconnect())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    @property
    def _certificate(self) -> Path:
        return self._folder / 'certificate.der'

    @property
    def _thumbprint(self) -> str:
        return hashlib.sha1(self._certificate.read_bytes()).hexdigest()

    @property
    def _uri(self) -> str:
        return f'urn:{socket.gethostname()}:asyncua'

    def _do(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE_S)

    async def _make_certificate(self) -> None:
        usage = [ExtendedKeyUsageOID.CLIENT_AUTH]
        await setup_self_signed_certificate(
            self._folder / 'key.pem',
            self._certificate,
            self._uri,
            socket.gethostname(),
            usage,
            {'commonName': 'asyncua'},
        )

    async def _connect(self, user: str) -> None:
        client = Client(
            self._endpoint, timeout=_BUSY_S, auto_reconnect=True, reconnect_max_delay=1.0
        )
        client.application_uri = self._uri
        client.set_user(user)
        client.set_password(PASSWORD)
        key = self._folder / 'key.pem'
        await client.set_security(SecurityPolicyBasic256Sha256, self._certificate, key)
        await client.connect()
        self._client = client
        await client.load_data_type_definitions()
        names = await client.get_namespace_array()
        cell, standard = names.index(NAMESPACE), names.index(JOB_CONTROL)
        subscription = await client.create_subscription(100, _Listener(self))
        results = client.get_node(ua.NodeId.from_string(f'ns={cell};s={RESULTS}'))
        event_type = ua.NodeId.from_string(f'ns={standard};i=1006')
        await subscription.subscribe_events(results, event_type, queuesize=1000)
        orders = client.get_node(ua.NodeId.from_string(f'ns={cell};s={ORDERS}'))
        await subscription.subscribe_data_change(orders)

    async def _disconnect(self) -> None:
        # The server may be gone.
        with contextlib.suppress(OSError, asyncio.TimeoutError, ua.UaError):
            await asyncio.wait_for(self._client.disconnect(), 5.0)


class _Listener:
    def __init__(self, owner: AsyncuaSubscriber) -> None:
        self._owner = owner

    def datachange_notification(self, node: Any, value: Any, data: Any) -> None:
        self._owner.lists.append([order.JobOrder.JobOrderID for order in value or ()])

    def event_notification(self, event: Any) -> None:
        state = state_of([{'stateText': entry.StateText.Text} for entry in event.JobState])
        self._owner.told.append((event.EventId, event.JobOrder.JobOrderID, state))

    def status_change_notification(self, status: Any) -> None:
        """The subscription has ended; it is made anew with the connection."""
