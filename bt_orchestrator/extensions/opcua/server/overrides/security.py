"""The knowledge of the overrides about users, passwords, certificates and options."""

from __future__ import annotations

import hashlib
import hmac
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from asyncua import ua
from asyncua.crypto import uacrypto
from cryptography.hazmat.primitives.asymmetric.rsa import RSAPrivateKey

from bt_orchestrator.extensions.opcua.server.nodesets import Access
from bt_orchestrator.extensions.opcua.server.pki import Own, Pki, own
from bt_orchestrator.extensions.opcua.server.trust import Trust
from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import KnownUsers, UsersUnusable
from bt_orchestrator.script.users.logins import Logins
from bt_orchestrator.script.users.passwords import LONGEST, Hashed

ENCRYPTED = (
    ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt,
    ua.SecurityPolicyType.Aes256Sha256RsaPss_SignAndEncrypt,
)
"""Older policies are broken (Basic128Rsa15, Basic256), and Sign alone lets everybody read."""


@dataclass(frozen=True)
class Security:
    """The clients that may connect, and the users who may log in."""

    access: Access
    own: Own
    trust: Trust
    people: People

    @classmethod
    def of(cls, node: str, access: Access) -> Security:
        """Return what the options say; makes a certificate at the first start.

        :raises PkiUnusable: the certificate cannot be made or used
        """
        pki = Pki(access.pki)
        return cls(access, own(pki, node, access.host), Trust(pki), People(access.users))

    @property
    def policies(self) -> list[ua.SecurityPolicyType]:
        """The offers to clients."""
        unencrypted = [ua.SecurityPolicyType.NoSecurity] if self.access.is_insecure else []
        return [*ENCRYPTED, *unencrypted]


# Users of the OPC UA server: those of the one file, with their roles of now.

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Person:
    """A user who has logged in."""

    name: str
    password: Hashed
    """With which they did; another one ends their sessions."""


class People:
    """Carries out logins, and knows who may still do what. For the loop's thread."""

    def __init__(self, users: Path, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin without failures.

        :param users: file of users
        :param clock: steady, seconds
        """
        self._users = KnownUsers(users)
        self._logins = Logins('opcua', self._users, clock, log)

    def log_in_here(self, name: str, password: str) -> Person:
        """Return who somebody at this computer is; takes a fifth of a second in this thread.

        :raises LoginRefused, MustWait, UsersUnusable: as `log_in`
        """
        user = self._logins.verify_here(name, password, 'this computer')
        log.info('%s (%s) logged in', name, user.role.value)
        return Person(name, user.password)

    async def log_in(self, name: str, password: str, address: str) -> Person:
        """Return who somebody is.

        :raises LoginRefused: there is no such user, or the password is another one
        :raises MustWait: there were too many attempts
        :raises UsersUnusable: nobody can log in
        """
        user = await self._logins.verify(name, password, address)
        log.info('%s (%s) logged in from %s', name, user.role.value, address)
        return Person(name, user.password)

    def role_of(self, person: Person) -> Role | None:
        """Return the role of now; None: the user was removed, or has another password."""
        try:
            user = self._users.get(person.name)
        except UsersUnusable as error:
            log.warning('%s', error)
            return None
        return user.role if user is not None and user.password == person.password else None

    def is_panel(self, person: Person, address: str, certificate: bytes) -> bool:
        """Tell whether somebody is at a panel of the line now (semantics 7.8).

        :param certificate: DER, of the client that signs the connection; empty: none does
        """
        thumbprint = hashlib.sha1(certificate).hexdigest() if certificate else ''
        try:
            return self._users.panels().have(person.name, address, thumbprint)
        except UsersUnusable:
            return False

    def close(self) -> None:
        """Check no more passwords."""
        self._logins.close()


# The password in a user's token, which is taken from an encrypted one or channel only.

_DECRYPT = {
    'http://www.w3.org/2001/04/xmlenc#rsa-oaep': 'decrypt_rsa_oaep',
    'http://opcfoundation.org/UA/security/rsa-oaep-sha2-256': 'decrypt_rsa_oaep_sha256',
}
"""Not RSA 1.5, which asyncua takes as well: who can ask often enough decrypts what others sent."""

_LONGEST_BYTES = 4 * LONGEST


class BadToken(ValueError):
    """It is not encrypted, or not as it has to be."""


def password_of(
    token: ua.UserNameIdentityToken, key: RSAPrivateKey, nonce: bytes, is_channel_encrypted: bool
) -> str:
    """Return the password of a token.

    :param nonce: the server's, of this session: asyncua does not look whether it is in the token,
        so a token could be sent again later
    :raises BadToken: it has none that may be believed
    """
    sent = bytes(token.Password or b'')
    if not token.EncryptionAlgorithm:
        if not is_channel_encrypted:
            raise BadToken('a password came unencrypted')
        return _text(sent)
    decrypt = _DECRYPT.get(token.EncryptionAlgorithm)
    if decrypt is None:
        raise BadToken(f'a password was encrypted by {token.EncryptionAlgorithm!r:.100}')
    try:
        plain = _in_blocks(getattr(uacrypto, decrypt), key, sent)
    except ValueError as error:
        raise BadToken('a password cannot be decrypted') from error
    length = int.from_bytes(plain[:4], 'little')
    secret = plain[4 : 4 + length]
    password, own_nonce = secret[: -len(nonce)], secret[-len(nonce) :]
    if len(secret) != length or not hmac.compare_digest(own_nonce, nonce):
        raise BadToken('a password was encrypted for another session')
    return _text(password)


def _in_blocks(
    decrypt: Callable[[RSAPrivateKey, bytes], bytes], key: RSAPrivateKey, sent: bytes
) -> bytes:
    size = key.key_size // 8
    if not sent or len(sent) % size or len(sent) > 8 * size:
        raise ValueError('no whole number of blocks')
    return b''.join(decrypt(key, sent[at : at + size]) for at in range(0, len(sent), size))


def _text(password: bytes) -> str:
    if len(password) > _LONGEST_BYTES:
        raise BadToken('a password is too long')
    try:
        return password.decode()
    except UnicodeDecodeError as error:
        raise BadToken('a password is no text in UTF-8') from error
