"""The certificate that the server makes for itself, as OPC 10000-6 6.2.2 wants it."""

from __future__ import annotations

import datetime
import re
import socket

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from bt_orchestrator.extensions.opcua.server import hosts
from bt_orchestrator.ports.doors.listening import address_in, is_everywhere

LIFETIME = datetime.timedelta(days=3652)
"""Ten years: a line is not stopped for a certificate."""

_USAGE = x509.KeyUsage(
    digital_signature=True,
    content_commitment=True,
    key_encipherment=True,
    data_encipherment=True,
    key_agreement=False,
    key_cert_sign=True,
    crl_sign=False,
    encipher_only=False,
    decipher_only=False,
)

_PURPOSES = (ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH)


def self_signed(key: rsa.RSAPrivateKey, uri: str, host: str) -> x509.Certificate:
    """Return a certificate that is signed with its own key.

    :param uri: application URI
    :param host: at which the server listens
    """
    name = x509.Name(
        [
            x509.NameAttribute(NameOID.COMMON_NAME, f'bt_orchestrator@{host_name()}'[:64]),
            x509.NameAttribute(NameOID.ORGANIZATION_NAME, 'bt_orchestrator'),
        ]
    )
    now = datetime.datetime.now(datetime.timezone.utc)
    identifier = x509.SubjectKeyIdentifier.from_public_key(key.public_key())
    return (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))  # clocks of clients differ
        .not_valid_after(now + LIFETIME)
        .add_extension(x509.SubjectAlternativeName(_other_names(uri, host)), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_USAGE, critical=True)
        .add_extension(x509.ExtendedKeyUsage(_PURPOSES), critical=False)
        .add_extension(identifier, critical=False)
        .add_extension(
            x509.AuthorityKeyIdentifier.from_issuer_subject_key_identifier(identifier),
            critical=False,
        )
        .sign(key, hashes.SHA256())
    )


def _other_names(uri: str, host: str) -> list[x509.GeneralName]:
    """Return the URI, and every name and address that a client may call the server by."""
    names, addresses = hosts.names(), hosts.addresses()
    address = address_in(host)
    if address is None:
        names.append(host)
    elif not is_everywhere(host):
        addresses.append(address)
    return [
        x509.UniformResourceIdentifier(uri),
        *map(x509.DNSName, dict.fromkeys(names)),
        *map(x509.IPAddress, dict.fromkeys(addresses)),
    ]


def host_name() -> str:
    """Return the name of this computer, as a URI can have it."""
    return re.sub(r'[^A-Za-z0-9.-]', '-', socket.gethostname()) or 'localhost'
