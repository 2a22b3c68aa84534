"""Requests of a connection: what is asked before, and who is asked for, is decided here."""

from __future__ import annotations

import logging
from typing import Any

from asyncua import ua
from asyncua.common.utils import Buffer, ServiceError
from asyncua.crypto.security_policies import SecurityPolicyNone
from asyncua.crypto.uacrypto import InvalidSignature
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.ua_binary import struct_from_binary, uatcp_to_binary
from cryptography.exceptions import InvalidSignature as InvalidSignatureInside

from bt_orchestrator.extensions.opcua.server.calls import Caller, calling, client_of
from bt_orchestrator.extensions.opcua.server.client_certificates import Untrusted, first_of
from bt_orchestrator.extensions.opcua.server.overrides import limits, services
from bt_orchestrator.extensions.opcua.server.overrides.inside import Inside
from bt_orchestrator.extensions.opcua.server.overrides.security import (
    BadToken,
    Person,
    password_of,
)
from bt_orchestrator.extensions.opcua.server.overrides.session import Session
from bt_orchestrator.extensions.opcua.server.pki import application_uri, parsed
from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.script.users.file import UsersUnusable
from bt_orchestrator.script.users.logins import LoginRefused, MustWait

spare = SpareLog(logging.getLogger(__name__))


class Closing(Exception):
    """The connection is closed; the client gets a status code, the log the reason."""

    def __init__(self, code: int, reason: str) -> None:
        self.code = code
        super().__init__(reason)


class Processor(UaProcessor):
    """Answers the requests of one connection."""

    iserver: Inside
    session: Session | None

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._security = self.iserver.security
        self._certificate = b''
        """Of the client, which is trusted; empty: the connection is not encrypted."""
        self._has_greeted = False

    # --- the connection -------------------------------------------------------------------------

    @property
    def _address(self) -> str:
        return str(self.name[0]) if self.name else ''

    @property
    def _is_encrypted(self) -> bool:
        policy = self._connection.security_policy
        return policy.Mode == ua.MessageSecurityMode.SignAndEncrypt

    def forget(self, subscription: int) -> None:
        """Stop answering for a subscription, which another connection has now."""
        self._publish_results_subs.pop(subscription, None)

    async def close(self) -> None:
        """End the session, unless it goes on at another connection."""
        if self.session is not None and self.session.transport not in (None, self._transport):
            self.session = None
        await super().close()

    def send_response(self, *args: Any, **options: Any) -> None:
        """Send; asyncua keeps everything that a client does not read."""
        super().send_response(*args, **options)
        if self._transport.get_write_buffer_size() > limits.UNREAD_BYTES:
            spare.warning(f'{self._address} does not read its answers; its connection is closed')
            self._transport.abort()

    async def process(self, header: Any, body: Buffer) -> bool:
        """Take a message; tells whether the connection goes on.

        asyncua goes on after what cannot be read, which it writes to the log with a traceback.
        """
        try:
            self._check_frame(header, body)
            return bool(await super().process(header, body))
        except Closing as error:
            code, reason = error.code, str(error)
        except Exception as error:  # noqa: BLE001 - the bytes of others make asyncua raise anything
            code = ua.StatusCodes.BadSecurityChecksFailed
            reason = f'its message cannot be read: {type(error).__name__}: {error}'
        spare.warning(f'connection of {self._address} closed: {reason}')
        error_message = ua.ErrorMessage(ua.StatusCode(code), None)
        self._transport.write(uatcp_to_binary(ua.MessageType.Error, error_message))
        return False

    def _check_frame(self, header: Any, body: Buffer) -> None:
        if header.MessageType == ua.MessageType.Hello:
            hello = struct_from_binary(ua.Hello, body.copy())
            least = limits.SMALLEST_CHUNK_BYTES
            if self._has_greeted or min(hello.ReceiveBufferSize, hello.SendBufferSize) < least:
                raise Closing(ua.StatusCodes.BadTcpMessageTypeInvalid, 'its greeting is wrong')
            self._has_greeted = True
        elif not self._has_greeted:
            raise Closing(ua.StatusCodes.BadTcpMessageTypeInvalid, 'it did not greet')
        elif header.MessageType == ua.MessageType.SecureOpen:
            self._check_opening(header, body)
        is_pending = self.session is None or not self.session.is_activated()
        if is_pending and len(self._connection._incoming_parts) >= limits.PENDING_CHUNKS:
            raise Closing(ua.StatusCodes.BadTcpMessageTooLarge, 'too long without a login')

    def _check_opening(self, header: Any, body: Buffer) -> None:
        """Ask whether a client is trusted before anything is decrypted, which costs more.

        asyncua looks at a certificate when a session is made, and then at the one that the client
        names there, which need not be the one that it proves to have.
        """
        if header.ChunkType != ua.ChunkType.Single:
            raise Closing(ua.StatusCodes.BadTcpMessageTypeInvalid, 'it opens a channel in parts')
        security = struct_from_binary(ua.AsymmetricAlgorithmHeader, body.copy(header.body_size))
        sent = bytes(security.SenderCertificate or b'')
        if self._connection.is_open():
            is_other = security.SecurityPolicyURI != self._connection.security_policy.URI
            if is_other or (self._is_encrypted and first_of(sent) != self._certificate):
                code = ua.StatusCodes.BadSecurityChecksFailed
                raise Closing(code, 'it changed its certificate or policy')
        elif security.SecurityPolicyURI != SecurityPolicyNone.URI:
            self._certificate = self._trusted(sent)

    def open_secure_channel(self, algohdr: Any, seqhdr: Any, body: Buffer) -> None:
        """Open the channel, or renew its keys, for as long as it may be."""
        request = struct_from_binary(ua.OpenSecureChannelRequest, body)
        wanted, connection = request.Parameters, self._connection
        if not connection.is_open():
            certificate = algohdr.SenderCertificate
            connection.select_policy(algohdr.SecurityPolicyURI, certificate, wanted.SecurityMode)
        needed = connection.security_policy.secure_channel_nonce_length
        if len(wanted.ClientNonce or b'') < needed:
            raise Closing(ua.StatusCodes.BadNonceInvalid, 'its nonce is too short')
        shortest, longest = limits.TOKEN_MS
        wanted.RequestedLifetime = min(max(wanted.RequestedLifetime, shortest), longest)
        response = ua.OpenSecureChannelResponse()
        response.Parameters = connection.open(wanted, self.iserver)
        handle = request.RequestHeader.RequestHandle
        self.send_response(handle, seqhdr, response, ua.MessageType.SecureOpen)

    def _trusted(self, sent: bytes) -> bytes:
        """Return the certificate of a client, without those of its authorities."""
        try:
            self._security.trust.check(sent)
        except Untrusted as error:
            raise Closing(ua.StatusCodes.BadSecurityChecksFailed, str(error)) from error
        return first_of(sent)

    # --- requests -------------------------------------------------------------------------------

    async def _process_message(
        self, typeid: ua.NodeId, requesthdr: Any, seqhdr: Any, body: Buffer
    ) -> Any:
        if typeid in services.DISCOVERY:
            return await super()._process_message(typeid, requesthdr, seqhdr, body)
        if typeid not in services.KNOWN:
            raise ServiceError(ua.StatusCodes.BadServiceUnsupported)
        # Whatever is offered, asyncua lets in whoever opens a channel without security.
        if not self._is_encrypted and not self._security.access.is_insecure:
            raise ServiceError(ua.StatusCodes.BadSecurityModeInsufficient)
        if typeid == services.CREATE_SESSION:
            return await self._create(typeid, requesthdr, seqhdr, body)
        if typeid == services.ACTIVATE_SESSION:
            return await self._activate(typeid, requesthdr, seqhdr, body)
        if self.session is None or not self.session.is_open:
            raise ServiceError(ua.StatusCodes.BadSessionIdInvalid)
        if typeid == services.CLOSE_SESSION:
            return await super()._process_message(typeid, requesthdr, seqhdr, body)
        with calling(await self._caller(self.session)):
            if typeid == services.TRANSFER:
                return await self._transfer(self.session, requesthdr, seqhdr, body)
            return await super()._process_message(typeid, requesthdr, seqhdr, body)

    async def _caller(self, session: Session) -> Caller:
        """Return who asks, if they still may."""
        if session.person is None:
            raise ServiceError(ua.StatusCodes.BadSessionNotActivated)
        if session.transport is not self._transport:
            raise ServiceError(ua.StatusCodes.BadSecureChannelIdInvalid)
        why = session.why_not(self._security)
        role = self._security.people.role_of(session.person)
        if why or role is None:
            await session.end(why)
            raise ServiceError(ua.StatusCodes.BadSessionClosed)
        person, is_panel = session.person, self._security.people.is_panel
        return Caller(
            person.name, role, session.client, str(session.session_id),
            is_panel(person, self._address, session.certificate),
        )  # fmt: skip

    async def _create(self, typeid: ua.NodeId, requesthdr: Any, seqhdr: Any, body: Buffer) -> Any:
        wanted = struct_from_binary(ua.CreateSessionParameters, body.copy())
        await self._check_creation(wanted)
        result = await super()._process_message(typeid, requesthdr, seqhdr, body)
        if self.session is not None:
            named = wanted.ClientDescription.ApplicationName.Text or wanted.SessionName
            self.session.client = client_of(named, self._address)
            self.session.certificate = self._certificate
            self.session.transport = self._transport
        return result

    async def _check_creation(self, wanted: Any) -> None:
        if self.session is not None and self.session.is_open:
            # asyncua would forget the first one, which then stays for ever.
            raise ServiceError(ua.StatusCodes.BadTooManySessions)
        if len(self.iserver.sessions) >= limits.SESSIONS and not await self._end_forsaken():
            spare.warning(f'a session for {self._address} was refused: {limits.SESSIONS} are open')
            raise ServiceError(ua.StatusCodes.BadTooManySessions)
        if not self._is_encrypted:
            return
        if first_of(bytes(wanted.ClientCertificate or b'')) != self._certificate:
            raise ServiceError(ua.StatusCodes.BadCertificateInvalid)
        if len(wanted.ClientNonce or b'') < 32:
            raise ServiceError(ua.StatusCodes.BadNonceInvalid)
        certified = application_uri(parsed(self._certificate))
        named = wanted.ClientDescription.ApplicationUri
        if named != certified:
            spare.warning(
                f'a client at {self._address} was refused: it says that its application URI is '
                f'{str(named)!r:.200}, and its certificate says {certified!r:.200}; the two have '
                'to be the same'
            )
            raise ServiceError(ua.StatusCodes.BadCertificateUriInvalid)

    async def _end_forsaken(self) -> bool:
        """End a session that waits for its client to come back; tells whether there was one.

        A client whose network comes and goes would else fill the places with its own sessions.
        """
        for session in self.iserver.sessions:
            if session.transport is not None and session.transport.is_closing():
                await session.end('its client is gone, and another one needs the place')
                return True
        return False

    async def _activate(
        self, typeid: ua.NodeId, requesthdr: Any, seqhdr: Any, body: Buffer
    ) -> Any:
        """Let somebody in, with a password that is checked outside the loop."""
        params = struct_from_binary(ua.ActivateSessionParameters, body.copy())
        token = requesthdr.AuthenticationToken
        session = self.session or self.iserver.lookup_external_session(token)
        if not isinstance(session, Session) or not session.is_open or session.auth_token != token:
            raise ServiceError(ua.StatusCodes.BadSessionIdInvalid)
        if session.certificate != self._certificate:
            # It goes on at another connection, which has to be one of the same client.
            raise ServiceError(ua.StatusCodes.BadSecurityChecksFailed)
        person = await self._person(params.UserIdentityToken, session)
        if session.person is not None and session.person.name != person.name:
            raise ServiceError(ua.StatusCodes.BadIdentityChangeNotSupported)
        session.let_in = person
        try:
            result = await super()._process_message(typeid, requesthdr, seqhdr, body)
        except (InvalidSignature, InvalidSignatureInside) as error:
            raise ServiceError(ua.StatusCodes.BadApplicationSignatureInvalid) from error
        finally:
            session.let_in = None
        session.transport = self._transport
        return result

    async def _person(self, token: Any, session: Session) -> Person:
        """Return who logs in.

        :raises ServiceError: nobody does
        """
        if not isinstance(token, ua.UserNameIdentityToken):
            spare.warning(f'{session.client} gave no name and password, and was refused')
            raise ServiceError(ua.StatusCodes.BadIdentityTokenRejected)
        key, nonce = self._security.own.key, session.nonce or b''
        try:
            password = password_of(token, key, nonce, self._is_encrypted)
            return await self._security.people.log_in(
                str(token.UserName or ''), password, self._address
            )
        except BadToken as error:
            spare.warning(f'a login of {session.client} was refused: {error}')
            raise ServiceError(ua.StatusCodes.BadIdentityTokenInvalid) from error
        except (LoginRefused, MustWait, UsersUnusable) as error:
            spare.warning(f'a login of {session.client} was refused: {error}')
            raise ServiceError(ua.StatusCodes.BadUserAccessDenied) from error

    async def _transfer(
        self, session: Session, requesthdr: Any, seqhdr: Any, body: Buffer
    ) -> bool:
        params = struct_from_binary(ua.TransferSubscriptionsParameters, body)
        response = ua.TransferSubscriptionsResponse()
        response.Parameters.Results = await session.take_over(params, self)
        self.send_response(requesthdr.RequestHandle, seqhdr, response)
        return True
