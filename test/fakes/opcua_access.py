"""Users and certificates of an OPC UA server in a folder, at no cost: keys are made once."""

from __future__ import annotations

import datetime
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID
from fakes.quick_users import PASSWORD, write_users

from bt_orchestrator.extensions.opcua.server.nodesets import Access
from bt_orchestrator.extensions.opcua.server.overrides.security import Security
from bt_orchestrator.extensions.opcua.server.pki import Pki, own
from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.panels import Panels

ROLES = {
    'stand': Role.ENGINEER, 'ann': Role.OPERATE, 'eve': Role.ENGINEER, 'mes': Role.MES,
    'vic': Role.VIEW,
}  # fmt: skip
"""Users of the server, with their roles."""

PANELS = {f'panel_{name}': role for name, role in ROLES.items()}
"""The same, each at a panel of the line."""

USER = 'stand'


def access_in(
    folder: Path,
    node: str,
    *,
    port: int = 0,
    roles: Mapping[str, Role] = ROLES,
    insecure: bool,
    plain: str = '',
) -> Access:
    """Return options with users and a certificate in a folder."""
    panels = Panels(tuple(PANELS))
    users = write_users(folder / 'users.yaml', {**roles, **PANELS}, panels=panels)
    pki = Pki(folder / 'pki')
    pki.make_folders()
    made = _made_once(node)
    for name in ('certs', 'private'):
        (file,) = (made / 'own' / name).iterdir()
        target = pki.root / 'own' / name / file.name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.touch(0o600)
        target.write_bytes(file.read_bytes())
    return Access(users, pki.root, port=port, is_insecure=insecure, plain=plain)


def any_security(node: str) -> Security:
    """Return what a server needs at which nobody logs in."""
    return Security.of(node, Access(Path('no users'), _made_once(node)))


@cache
def _made_once(node: str) -> Path:
    folder = Path(tempfile.mkdtemp(prefix='opcua-pki-'))
    own(Pki(folder), node, '127.0.0.1')
    return folder


def with_login(address: str, name: str = USER, password: str = PASSWORD) -> str:
    """Return the address with a user, as asyncua's client takes it."""
    scheme, _, host = address.partition('://')
    return f'{scheme}://{name}:{password.replace(" ", "%20")}@{host}'


URI = 'urn:test:client'


@cache
def client_key(bits: int = 2048) -> rsa.RSAPrivateKey:
    """Return a key of a client, the same for all."""
    return rsa.generate_private_key(public_exponent=65537, key_size=bits)


def certificate(
    name: str = 'client',
    *,
    uri: str = URI,
    key: rsa.RSAPrivateKey | None = None,
    issuer: tuple[x509.Certificate, rsa.RSAPrivateKey] | None = None,
    is_authority: bool = False,
    days: tuple[int, int] = (-1, 10),
) -> x509.Certificate:
    """Return a certificate, signed by itself or by an authority.

    :param days: from when to when it is valid, from now
    """
    key = key or client_key()
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    now = datetime.datetime.now(datetime.timezone.utc)
    first, last = (now + datetime.timedelta(days=day) for day in days)
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer[0].subject if issuer else subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(first)
        .not_valid_after(last)
        .add_extension(x509.BasicConstraints(is_authority, None), critical=True)
    )
    if uri:
        names = x509.SubjectAlternativeName([x509.UniformResourceIdentifier(uri)])
        builder = builder.add_extension(names, critical=False)
    return builder.sign(issuer[1] if issuer else key, hashes.SHA256())


def write_client(folder: Path, certificate: x509.Certificate) -> tuple[Path, Path]:
    """Write a certificate and its key for asyncua's client; returns the files."""
    paths = folder / 'client.der', folder / 'client.pem'
    paths[0].write_bytes(certificate.public_bytes(Encoding.DER))
    paths[1].write_bytes(
        client_key().private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    )
    return paths
