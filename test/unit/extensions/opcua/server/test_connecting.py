"""Who gets in: encrypted, with a trusted certificate, as a user; tried with asyncua's client."""

from __future__ import annotations

import asyncio
from typing import Any

import asyncua
import pytest
from asyncua import ua
from asyncua.crypto import security_policies as policies
from cryptography.hazmat.primitives.serialization import Encoding
from fakes.guarded import NODE, SOON_S, Bench, Served, becomes, code_of
from fakes.opcua_access import ROLES, URI, certificate
from fakes.quick_users import write_users

from bt_orchestrator.extensions.opcua.server.client_certificates import thumbprint
from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile

CODES = ua.StatusCodes


async def called(bench: Bench, client: asyncua.Client) -> None:
    parent = client.nodes.objects
    await parent.call_method(client.get_node(bench.method.nodeid))


async def refused(work: Any) -> bool:
    """Tell whether a connection does not come about, in whatever way a client learns it."""
    try:
        await asyncio.wait_for(work, SOON_S)
    except (ua.UaError, ConnectionError, TimeoutError, asyncio.TimeoutError):
        return True
    return False


@pytest.mark.parametrize(
    'policy', [policies.SecurityPolicyBasic256Sha256, policies.SecurityPolicyAes256Sha256RsaPss]
)
def test_a_user_with_a_trusted_certificate_gets_in(secure: Served, policy: Any) -> None:
    async def work(bench: Bench) -> None:
        async with await bench.secure(bench.trusted(), policy=policy) as client:
            assert await client.get_node(bench.variable.nodeid).read_value() == 1
            await called(bench, client)
        (caller,) = bench.callers
        assert (caller.name, caller.role) == ('mes', Role.MES)
        assert caller.client.endswith(' at 127.0.0.1')

    secure(work)


def test_users_call_with_roles_from_file(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        made = bench.trusted()
        for name in ROLES:
            async with await bench.secure(made, name) as client:
                await called(bench, client)
        assert {caller.name: caller.role for caller in bench.callers} == dict(ROLES)

    secure(work)


def test_7_8_3_panel_certificate_marks_caller_as_panel(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        made = bench.trusted()
        users = UsersFile(bench.security.access.users)
        async with await bench.secure(made) as client:
            for named in (False, True, False):
                if named or bench.callers:
                    users.change_panel('certificate', thumbprint(made), named=named)
                await called(bench, client)
        assert [caller.is_panel for caller in bench.callers] == [False, True, False]
        users.change_panel('address', '127.0.0.1', named=True)
        async with await bench.secure(made) as client:
            await called(bench, client)
        assert bench.callers[-1].is_panel

    secure(work)


@pytest.mark.parametrize(
    ('policy', 'mode'),
    [
        (policies.SecurityPolicyBasic256Sha256, ua.MessageSecurityMode.Sign),
        (policies.SecurityPolicyAes128Sha256RsaOaep, ua.MessageSecurityMode.SignAndEncrypt),
        (policies.SecurityPolicyBasic256, ua.MessageSecurityMode.SignAndEncrypt),
        (policies.SecurityPolicyBasic128Rsa15, ua.MessageSecurityMode.SignAndEncrypt),
    ],
)
def test_other_policies_are_refused(secure: Served, policy: Any, mode: Any) -> None:
    async def work(bench: Bench) -> None:
        client = await bench.secure(bench.trusted(), policy=policy, mode=mode)
        assert await refused(client.connect())

    secure(work)


def test_unencrypted_client_learns_only_endpoints(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = bench.plain()
        endpoints = await client.connect_and_get_server_endpoints()
        assert {item.SecurityMode for item in endpoints} == {ua.MessageSecurityMode.SignAndEncrypt}
        tokens = {token.TokenType for item in endpoints for token in item.UserIdentityTokens}
        assert tokens == {ua.UserTokenType.UserName}
        await client.connect_socket()
        await client.send_hello()
        await client.open_secure_channel()
        # asyncua's server alone makes a session here, although no such endpoint is offered.
        assert await code_of(client.create_session()) == CODES.BadSecurityModeInsufficient
        client.disconnect_socket()

    secure(work)


def test_nobody_is_anonymous(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = await bench.secure(bench.trusted())
        client._username = client._password = None
        assert await refused(client.connect())
        assert not [login for login in bench.server.inside.sessions if login.person is not None]

    secure(work)


@pytest.mark.parametrize('name', ['mes', 'nobody'])
def test_a_wrong_password_is_refused(secure: Served, name: str) -> None:
    async def work(bench: Bench) -> None:
        client = await bench.secure(bench.trusted(), name, 'a guess')
        assert await code_of(client.connect()) == CODES.BadUserAccessDenied

    secure(work)


def test_insecure_server_requires_login_with_encrypted_password(
    insecure: Served,
) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            await called(bench, client)
        assert await code_of(bench.plain('mes', 'a guess').connect()) == CODES.BadUserAccessDenied
        clear = bench.plain()
        clear._encrypt_password = lambda password, _: (password.encode(), '')
        assert await code_of(clear.connect()) == CODES.BadIdentityTokenInvalid

    insecure(work)


# --- certificates -------------------------------------------------------------------------------


def test_refused_certificate_can_be_trusted_without_restart(
    secure: Served, caplog: pytest.LogCaptureFixture
) -> None:
    made = certificate('UaExpert')

    async def work(bench: Bench) -> None:
        assert await refused((await bench.secure(made)).connect())
        (rejected,) = bench.trust.rejected()
        assert rejected.certificate == made
        assert f'opcua trust --pki {bench.folder}/pki {thumbprint(made)[:8]}' in caplog.text
        bench.trust.trust(thumbprint(made)[:8])
        assert not bench.trust.rejected()
        async with await bench.secure(made) as client:
            await called(bench, client)

    secure(work)


def test_the_certificate_of_another_helps_nobody(secure: Served) -> None:
    """A certificate is public; asyncua looks at the one that a client names, not at its own."""
    known, own = certificate('known'), certificate('mallory')

    async def work(bench: Bench) -> None:
        bench.trusted(known)
        assert await refused((await bench.secure(own)).connect())

    secure(work)


def test_session_needs_certificate_of_its_connection(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        client = await bench.secure(bench.trusted())
        await client.connect_socket()
        await client.send_hello()
        await client.open_secure_channel()
        for other in (b'', certificate('other').public_bytes(Encoding.DER)):
            client.security_policy.host_certificate = other
            assert await code_of(client.create_session()) == CODES.BadCertificateInvalid
        client.disconnect_socket()

    secure(work)


def test_a_client_names_the_uri_of_its_certificate(
    secure: Served, caplog: pytest.LogCaptureFixture
) -> None:
    async def work(bench: Bench) -> None:
        client = await bench.secure(bench.trusted(), uri='urn:another')
        assert await code_of(client.connect()) == CODES.BadCertificateUriInvalid
        assert 'urn:another' in caplog.text
        assert URI in caplog.text

    secure(work)


def test_expired_certificate_is_refused_although_trusted(
    secure: Served, caplog: pytest.LogCaptureFixture
) -> None:
    made = certificate(days=(-10, -1))

    async def work(bench: Bench) -> None:
        bench.security.trust._clock = lambda: made.not_valid_before_utc.timestamp() + 1
        bench.trusted(made)
        bench.security.trust._clock = lambda: made.not_valid_after_utc.timestamp() + 1
        assert await refused((await bench.secure(made)).connect())
        assert 'it needs a new certificate, or a clock is wrong' in caplog.text

    secure(work)


# --- what counts at once ------------------------------------------------------------------------


def test_a_removed_user_is_out_at_once(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain() as client:
            await called(bench, client)
            write_users(bench.security.access.users, {'ann': Role.OPERATE})
            assert await code_of(called(bench, client)) == CODES.BadSessionClosed
            assert len(bench.callers) == 1

    insecure(work)


def test_removal_ends_session_of_listening_user(insecure: Served) -> None:
    async def work(bench: Bench) -> None:
        async with bench.plain():
            write_users(bench.security.access.users, {'ann': Role.OPERATE})
            await becomes(lambda: not bench.server.inside.sessions)

    insecure(work)


def test_removed_certificate_ends_its_sessions(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        made = bench.trusted()
        client = await bench.secure(made)
        await client.connect()
        bench.trust.remove(thumbprint(made))
        await becomes(lambda: not bench.server.inside.sessions)
        assert await refused((await bench.secure(made)).connect())
        await refused(client.disconnect())

    secure(work)


def test_the_server_has_its_uri_from_its_certificate(secure: Served) -> None:
    async def work(bench: Bench) -> None:
        (first, *_) = await bench.plain().connect_and_get_server_endpoints()
        assert first.Server.ApplicationUri == bench.security.own.uri
        assert NODE.strip('/').replace('/', '.') in bench.security.own.uri

    secure(work)
