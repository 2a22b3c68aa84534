"""The server of OPC UA without a cell: one variable, one method, and clients to try it with."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import asyncua
from asyncua import ua
from asyncua.crypto import security_policies
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from fakes.opcua_access import URI, access_in, certificate, write_client
from fakes.quick_users import PASSWORD
from opcua_reader import client_of

from bt_orchestrator.extensions.opcua.server.calls import CALLER, Caller
from bt_orchestrator.extensions.opcua.server.client_certificates import Untrusted, thumbprint
from bt_orchestrator.extensions.opcua.server.overrides.security import Security
from bt_orchestrator.extensions.opcua.server.overrides.server import GuardedServer
from bt_orchestrator.extensions.opcua.server.trust import Trust
from bt_orchestrator.script.users.logins import Attempts

T = TypeVar('T')

NODE = '/line/bt_orchestrator'
SOON_S = 10.0
"""The longest wait for something that must come."""


@dataclass
class Bench:
    """A server that listens, and who called its method."""

    folder: Path
    server: GuardedServer
    security: Security
    variable: Any = None
    method: Any = None
    callers: list[Caller] = field(default_factory=list)
    fails_with: Exception | None = None
    """What the method raises."""

    @property
    def url(self) -> str:
        return f'opc.tcp://127.0.0.1:{self.server.bserver.port}'

    @property
    def trust(self) -> Trust:
        return self.security.trust

    def trusted(self, cert: x509.Certificate | None = None) -> x509.Certificate:
        """Trust the certificate of a client."""
        made = cert or certificate()
        trust_it(self.trust, made)
        return made

    def plain(self, name: str = 'mes', password: str = PASSWORD) -> asyncua.Client:
        """Return a client without encryption."""
        client = client_of(self.url)
        client.set_user(name)
        client.set_password(password)
        return client

    async def secure(
        self,
        cert: x509.Certificate,
        name: str = 'mes',
        password: str = PASSWORD,
        *,
        uri: str = URI,
        policy: Any = security_policies.SecurityPolicyBasic256Sha256,
        mode: Any = ua.MessageSecurityMode.SignAndEncrypt,
    ) -> asyncua.Client:
        """Return a client with a certificate."""
        client = self.plain(name, password)
        client.application_uri = uri
        own, key = write_client(self.folder, cert)
        server = self.security.own.certificate.public_bytes(Encoding.DER)
        await client.set_security(policy, own, key, server_certificate=server, mode=mode)
        return client


def trust_it(trust: Trust, cert: x509.Certificate) -> None:
    """Trust a certificate as people do: after it was refused."""
    try:
        trust.check(cert.public_bytes(Encoding.DER))
    except Untrusted:
        trust.trust(thumbprint(cert))


class Served:
    """A server that runs for many tests: loading what every server has takes seconds."""

    def __init__(self, folder: Path, *, insecure: bool) -> None:
        self._folder = folder
        self._insecure = insecure
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self.bench = self._do(self._begin())

    def __call__(self, what: Callable[[Bench], Awaitable[None]]) -> None:
        """Do something with a server that nobody has used."""
        self._do(self._fresh(what))

    def close(self) -> None:
        """Stop it."""
        self._do(self._end())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(SOON_S)
        self._loop.close()

    def _do(self, work: Coroutine[Any, Any, T]) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(120)

    async def _begin(self) -> Bench:
        access = access_in(self._folder, NODE, insecure=self._insecure)
        security = Security.of(NODE, access)
        server = GuardedServer(security)
        await server.init()
        server.set_endpoint('opc.tcp://127.0.0.1:0')
        bench = Bench(self._folder, server, security)
        index = await server.register_namespace('urn:test')
        objects = server.nodes.objects
        bench.variable = await objects.add_variable(ua.NodeId('value', index), 'value', 1)

        async def call(parent: ua.NodeId, *given: ua.Variant) -> list[ua.Variant]:
            bench.callers.append(CALLER.get())
            if bench.fails_with is not None:
                raise bench.fails_with
            return []

        bench.method = await objects.add_method(ua.NodeId('call', index), 'call', call, [], [])
        await server.start()
        return bench

    async def _fresh(self, what: Callable[[Bench], Awaitable[None]]) -> None:
        bench = self.bench
        access_in(self._folder, NODE, insecure=self._insecure)
        for listed in (*bench.trust.trusted(), *bench.trust.rejected()):
            listed.path.unlink()
        bench.trust._clock = time.time
        bench.security.people._logins._attempts = Attempts()
        bench.callers.clear()
        bench.fails_with = None
        before = asyncio.all_tasks()
        try:
            await what(bench)
        finally:
            for session in bench.server.inside.sessions:
                await session.close_session(True)
            for client in list(bench.server.bserver.clients):
                client.transport.abort()
            await becomes(lambda: not bench.server.bserver.clients)
            closing = bench.server.bserver.closing_tasks
            await becomes(lambda: all(task.done() for task in closing))
            for task in asyncio.all_tasks() - before:  # clients that were cut off
                task.cancel()

    async def _end(self) -> None:
        await self.bench.server.stop()
        self.bench.security.people.close()


async def becomes(is_so: Callable[[], bool]) -> None:
    """Wait until something is so."""
    deadline = asyncio.get_running_loop().time() + SOON_S
    while not is_so():
        assert asyncio.get_running_loop().time() < deadline, 'it did not happen'
        await asyncio.sleep(0.02)


async def code_of(work: Awaitable[object]) -> int:
    """Return the status code that something fails with; 0: none."""
    try:
        await work
    except ua.UaStatusCodeError as error:
        return int(error.code)
    return 0
