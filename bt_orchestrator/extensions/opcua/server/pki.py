"""The folders of certificates, and the server's own one, which it makes at its first start."""

from __future__ import annotations

import datetime
import fcntl
import ipaddress
import os
import re
import socket
import stat
import struct
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    load_der_private_key,
    load_pem_private_key,
)
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.ordinary_file import open_ordinary, read_ordinary, read_up_to
from bt_orchestrator.ports.doors.listening import address_in, is_everywhere
from bt_orchestrator.script.users.file import own_folder

KEY_BITS = 3072
LARGEST_FILE = 1_000_000
"""Bytes of a certificate, a key or a list of revoked ones."""
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


class PkiUnusable(OrchestratorError):
    """The server's own certificate or its key cannot be used; says why and what to do."""


@dataclass(frozen=True)
class Pki:
    """The folders, called and arranged as those of other OPC UA servers."""

    root: Path

    @property
    def trusted(self) -> Path:
        """Certificates of clients, or of authorities, that may connect."""
        return self.root / 'trusted' / 'certs'

    @property
    def issuers(self) -> Path:
        """Certificates of authorities between those and clients; trusted for nothing else."""
        return self.root / 'issuers' / 'certs'

    @property
    def rejected(self) -> Path:
        """Certificates of clients that were refused because they are not trusted yet."""
        return self.root / 'rejected' / 'certs'

    @property
    def revocations(self) -> tuple[Path, Path]:
        """Lists of certificates that their authorities have taken back."""
        return self.root / 'trusted' / 'crl', self.root / 'issuers' / 'crl'

    def make_folders(self) -> None:
        """Make those that are missing, for their owner alone.

        :raises PkiUnusable: the disk does not let it
        """
        try:
            for folder in (self.trusted, self.issuers, self.rejected, *self.revocations):
                folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise PkiUnusable(_out_of_reach(error)) from error


@dataclass(frozen=True)
class Own:
    """The proof of the server's identity."""

    certificate: x509.Certificate
    key: rsa.RSAPrivateKey
    uri: str
    """The server's application URI: what the certificate says."""


def default_pki(environment: Mapping[str, str]) -> Path:
    """Return where the folders are unless somebody says otherwise."""
    return own_folder(environment, 'XDG_CONFIG_HOME', '.config') / 'pki'


def own(pki: Pki, node: str, host: str) -> Own:
    """Return the certificate of the server of a node; makes one if there is none.

    :param node: full name
    :param host: at which the server listens
    :raises PkiUnusable: it is damaged or has expired, or others may read its key
    """
    stem = re.sub(r'[^\w.-]', '_', node.strip('/').replace('/', '.'))
    certificate = pki.root / 'own' / 'certs' / f'{stem}.der'
    key = pki.root / 'own' / 'private' / f'{stem}.pem'
    pki.make_folders()
    if not certificate.exists() and not key.exists():
        _make(certificate, key, f'urn:{host_name()}:bt_orchestrator:{stem}', host)
    return _read(certificate, key)


def application_uri(certificate: x509.Certificate) -> str:
    """Return the application URI of a certificate; empty: it has none."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName)
    except (x509.ExtensionNotFound, ValueError):
        return ''
    return next(iter(names.value.get_values_for_type(x509.UniformResourceIdentifier)), '')


def parsed(content: bytes) -> x509.Certificate:
    """Return a certificate, PEM or DER.

    :raises ValueError: it is none
    """
    if content.lstrip().startswith(b'-----BEGIN'):
        return x509.load_pem_x509_certificate(content)
    return x509.load_der_x509_certificate(content)


# --- reading ------------------------------------------------------------------------------------


def _read(path: Path, key_path: Path) -> Own:
    anew = f'remove {path} and {key_path}, and a new one is made at the next start'
    try:
        certificate = parsed(read_ordinary(path, LARGEST_FILE))
        key = _read_key(key_path)
    except OSError as error:
        raise PkiUnusable(
            f'{error.filename}: {error.strerror}; a certificate and its key belong together: '
            f'bring it back, or {anew}'
        ) from error
    except (TypeError, ValueError) as error:
        raise PkiUnusable(
            f'{path} and {key_path} are no certificate and its RSA key without a password, each '
            f'PEM or DER ({str(error)[:200]}); bring a copy back, or {anew}'
        ) from error
    if certificate.public_key() != key.public_key():
        raise PkiUnusable(f'{key_path} is not the key of {path}; bring it back, or {anew}')
    uri = application_uri(certificate)
    if not uri:
        raise PkiUnusable(f'{path} has no application URI (a URI in subjectAltName); {anew}')
    if certificate.not_valid_after_utc <= datetime.datetime.now(datetime.timezone.utc):
        raise PkiUnusable(
            f'{path} has expired on {certificate.not_valid_after_utc:%Y-%m-%d}; {anew}: every '
            'client has to trust that one'
        )
    return Own(certificate, key, uri)


def _read_key(path: Path) -> rsa.RSAPrivateKey:
    with open_ordinary(path) as file:
        mode = os.fstat(file.fileno()).st_mode
        content = read_up_to(file, LARGEST_FILE)
    if mode & _OTHERS:
        raise PkiUnusable(
            f'{path}: other users of this computer may read it (mode {mode & 0o777:o}), and '
            'could pretend to be this server; chmod 600 it, and make a new one if in doubt'
        )
    load = load_pem_private_key if content.lstrip().startswith(b'-----') else load_der_private_key
    key = load(content, password=None)
    if not isinstance(key, rsa.RSAPrivateKey):
        raise TypeError(f'an RSA key was expected, found {type(key).__name__}')
    return key


# --- making -------------------------------------------------------------------------------------


def _out_of_reach(error: OSError) -> str:
    return f'{error.filename}: {error.strerror}; check the folder and its permissions'


def _make(path: Path, key_path: Path, uri: str, host: str) -> None:
    key = rsa.generate_private_key(public_exponent=65537, key_size=KEY_BITS)
    certificate = self_signed(key, uri, host)
    try:
        for folder in (path.parent, key_path.parent):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        _write(key_path, key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
        _write(path, certificate.public_bytes(Encoding.DER))
    except OSError as error:
        raise PkiUnusable(_out_of_reach(error)) from error


def _write(path: Path, content: bytes) -> None:
    """Write a file for its owner alone, whole or not at all."""
    descriptor, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)  # 0600
    with os.fdopen(descriptor, 'wb') as file:
        file.write(content)
        file.flush()
        os.fsync(descriptor)
    Path(name).replace(path)


# Names and addresses of this computer, for the certificate of the server.

_SIOCGIFADDR = 0x8915
_IF_INET6 = Path('/proc/net/if_inet6')

Address = ipaddress.IPv4Address | ipaddress.IPv6Address


def host_names() -> list[str]:
    """Return the names by which clients may call this computer."""
    names = (socket.gethostname(), socket.getfqdn(), 'localhost')
    return list(dict.fromkeys(name for name in names if name and name.isascii()))


def host_addresses() -> list[Address]:
    """Return the addresses of every network interface."""
    return list(dict.fromkeys((*_of_version_4(), *_of_version_6())))


def _of_version_4() -> Iterator[Address]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for _, interface in socket.if_nameindex():
            with suppress(OSError):  # it has no such address
                request = struct.pack('256s', interface.encode()[:15])
                reply = fcntl.ioctl(probe.fileno(), _SIOCGIFADDR, request)
                yield ipaddress.IPv4Address(reply[20:24])


def _of_version_6() -> Iterator[Address]:
    with suppress(OSError):  # IPv6 is switched off
        for line in _IF_INET6.read_text().splitlines():
            yield ipaddress.IPv6Address(bytes.fromhex(line.split()[0]))


# The certificate that the server makes for itself, as OPC 10000-6 6.2.2 wants it.

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
    names, addresses = host_names(), host_addresses()
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
