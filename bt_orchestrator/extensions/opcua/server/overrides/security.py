"""The knowledge of the overrides about users, certificates and options."""

from __future__ import annotations

from dataclasses import dataclass

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.access import Access
from bt_orchestrator.extensions.opcua.server.people import People
from bt_orchestrator.extensions.opcua.server.pki import Own, Pki, own
from bt_orchestrator.extensions.opcua.server.trust import Trust

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
