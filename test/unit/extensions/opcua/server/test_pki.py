"""The server's own certificate: made once, for its owner alone, and refused when it is no good."""

from __future__ import annotations

import datetime
import ipaddress
import os
import socket
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import ExtendedKeyUsageOID
from fakes.opcua_access import certificate, client_key

from bt_orchestrator.extensions.opcua.server import pki
from bt_orchestrator.extensions.opcua.server.pki import (
    Own,
    Pki,
    PkiUnusable,
    application_uri,
    default_pki,
    own,
)

NODE = '/line_1/bt_orchestrator'


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Pki:
    monkeypatch.setattr(pki, 'KEY_BITS', 2048)  # quicker
    return Pki(tmp_path / 'pki')


def files(folders: Pki) -> tuple[Path, Path]:
    own_folder = folders.root / 'own'
    (certificate,) = (own_folder / 'certs').iterdir()
    (key,) = (own_folder / 'private').iterdir()
    return certificate, key


def made(folders: Pki, host: str = '127.0.0.1') -> Own:
    return own(folders, NODE, host)


def test_certificate_is_made_once_and_kept(folders: Pki) -> None:
    first = made(folders)
    assert made(folders).certificate == first.certificate
    assert own(folders, '/line_2/bt_orchestrator', '127.0.0.1').certificate != first.certificate


def test_the_key_is_for_its_owner_alone(folders: Pki) -> None:
    umask = os.umask(0)
    try:
        made(folders)
    finally:
        os.umask(umask)
    _, key = files(folders)
    assert key.stat().st_mode & 0o777 == 0o600
    assert folders.root.joinpath('own', 'private').stat().st_mode & 0o777 == 0o700


def test_it_is_valid_for_ten_years_and_strong(folders: Pki) -> None:
    server = made(folders)
    now = datetime.datetime.now(datetime.timezone.utc)
    assert server.certificate.not_valid_before_utc < now
    left = server.certificate.not_valid_after_utc - now
    assert datetime.timedelta(days=3650) < left < datetime.timedelta(days=3653)
    assert server.certificate.signature_hash_algorithm is not None
    assert server.certificate.signature_hash_algorithm.name == 'sha256'
    assert pki.KEY_BITS >= 2048


def test_certificate_names_server_and_all_addresses(folders: Pki) -> None:
    server = made(folders, 'line-pc.plant.example')
    extension = server.certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName)
    names = extension.value.get_values_for_type(x509.DNSName)
    addresses = extension.value.get_values_for_type(x509.IPAddress)
    assert extension.value.get_values_for_type(x509.UniformResourceIdentifier) == [server.uri]
    assert server.uri.endswith(':bt_orchestrator:line_1.bt_orchestrator')
    assert {'localhost', socket.gethostname(), 'line-pc.plant.example'} <= set(names)
    assert set(pki.host_addresses()) <= set(addresses)
    assert ipaddress.ip_address('127.0.0.1') in addresses


def test_certificate_has_opc_ua_key_usages(folders: Pki) -> None:
    extensions = made(folders).certificate.extensions
    usage = extensions.get_extension_for_class(x509.KeyUsage).value
    assert usage.digital_signature
    assert usage.content_commitment
    assert usage.key_encipherment
    assert usage.data_encipherment
    purposes = extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
    assert ExtendedKeyUsageOID.SERVER_AUTH in purposes


def test_uri_stays_when_computer_is_renamed(folders: Pki, monkeypatch: pytest.MonkeyPatch) -> None:
    first = made(folders)
    monkeypatch.setattr(socket, 'gethostname', lambda: 'renamed')
    assert made(folders).uri == first.uri


# --- what is refused ----------------------------------------------------------------------------


def refusal(folders: Pki) -> str:
    with pytest.raises(PkiUnusable) as refused:
        made(folders)
    return str(refused.value)


def test_a_key_that_others_may_read_is_refused(folders: Pki) -> None:
    made(folders)
    _, key = files(folders)
    key.chmod(0o644)
    assert f'{key}: other users of this computer may read it (mode 644)' in refusal(folders)


@pytest.mark.parametrize('which', [0, 1])
def test_missing_key_or_certificate_is_not_regenerated(folders: Pki, which: int) -> None:
    made(folders)
    gone = files(folders)[which]
    gone.unlink()
    assert f'{gone}: No such file or directory' in refusal(folders)
    assert not gone.exists()


@pytest.mark.parametrize('which', [0, 1])
def test_a_damaged_file_is_refused(folders: Pki, which: int) -> None:
    made(folders)
    files(folders)[which].write_bytes(b'nothing')
    assert 'are no certificate and its RSA key' in refusal(folders)


@pytest.mark.parametrize('which', [0, 1])
def test_pipe_instead_of_file_is_refused_immediately(folders: Pki, which: int) -> None:
    made(folders)
    path = files(folders)[which]
    path.unlink()
    os.mkfifo(path)
    assert f'{path}: this is a pipe or a device, and no ordinary file' in refusal(folders)


def test_the_key_of_another_is_refused(folders: Pki) -> None:
    made(folders)
    path, key = files(folders)
    path.write_bytes(certificate().public_bytes(Encoding.DER))
    assert f'{key} is not the key of {path}' in refusal(folders)


@pytest.mark.parametrize(
    ('options', 'message'),
    [({'days': (-10, -1)}, 'has expired on'), ({'uri': ''}, 'has no application URI')],
)
def test_site_certificate_must_be_valid(
    folders: Pki, monkeypatch: pytest.MonkeyPatch, options: dict[str, object], message: str
) -> None:
    client_key()  # made before there is no other
    monkeypatch.setattr(rsa, 'generate_private_key', lambda **_: client_key())
    made(folders)
    path, _ = files(folders)
    path.write_bytes(certificate(**options).public_bytes(Encoding.PEM))  # type: ignore[arg-type]
    assert message in refusal(folders)


def test_unwritable_folder_gives_clear_error(tmp_path: Path) -> None:
    (tmp_path / 'pki').write_text('a file')
    with pytest.raises(PkiUnusable, match='pki'):
        own(Pki(tmp_path / 'pki'), NODE, '127.0.0.1')


def test_where_the_folders_are(tmp_path: Path) -> None:
    assert default_pki({'XDG_CONFIG_HOME': '/x'}) == Path('/x/bt_orchestrator/pki')
    assert default_pki({}).is_relative_to(Path.home())


def test_a_certificate_without_names_has_no_uri() -> None:
    assert application_uri(certificate(uri='')) == ''
