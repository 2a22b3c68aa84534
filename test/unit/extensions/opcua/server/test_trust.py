"""Which certificates of clients are believed: trusted ones, and those of authorities."""

from __future__ import annotations

import datetime
import os
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import NameOID
from fakes.opcua_access import certificate, client_key

from bt_orchestrator.extensions.opcua.server import trust as module
from bt_orchestrator.extensions.opcua.server.client_certificates import Untrusted, thumbprint
from bt_orchestrator.extensions.opcua.server.pki import Pki
from bt_orchestrator.extensions.opcua.server.trust import NoSuchCertificate, Trust

_AUTHORITY_KEY = rsa.generate_private_key(public_exponent=65537, key_size=2048)


@pytest.fixture
def pki(tmp_path: Path) -> Pki:
    made = Pki(tmp_path / 'pki')
    made.make_folders()
    return made


@pytest.fixture
def trust(pki: Pki) -> Trust:
    return Trust(pki)


def der(cert: x509.Certificate) -> bytes:
    return cert.public_bytes(Encoding.DER)


def refusal(trust: Trust, content: bytes | x509.Certificate) -> str:
    with pytest.raises(Untrusted) as refused:
        trust.check(content if isinstance(content, bytes) else der(content))
    return str(refused.value)


def put(folder: Path, cert: x509.Certificate, name: str = 'one.der') -> None:
    (folder / name).write_bytes(cert.public_bytes(Encoding.PEM if 'pem' in name else Encoding.DER))


@pytest.mark.parametrize('name', ['one.der', 'one.pem', 'One.CRT', 'a b [c].cer'])
def test_trusted_folder_accepts_any_file_name(pki: Pki, trust: Trust, name: str) -> None:
    cert = certificate()
    put(pki.trusted, cert, name)
    assert trust.check(der(cert)) == cert
    assert trust.check(der(cert) + der(certificate('its authority'))) == cert  # a chain


def test_trusted_folder_changes_apply_at_once(pki: Pki, trust: Trust) -> None:
    cert = certificate()
    assert 'is not trusted' in refusal(trust, cert)
    put(pki.trusted, cert)
    trust.check(der(cert))
    (pki.trusted / 'one.der').unlink()
    assert 'is not trusted' in refusal(trust, cert)


def test_unusable_files_do_not_block_trusted_ones(pki: Pki, trust: Trust) -> None:
    (pki.trusted / 'bad.der').write_bytes(b'nothing')
    os.mkfifo(pki.trusted / 'pipe.der')
    (pki.trusted / 'endless.der').symlink_to('/dev/zero')
    (pki.trusted / 'readme.txt').write_text('put certificates here')
    cert = certificate()
    put(pki.trusted, cert)
    trust.check(der(cert))


# --- what is refused whoever trusts it ----------------------------------------------------------


def test_what_is_no_certificate_is_refused(trust: Trust) -> None:
    for content in (b'', b'x', b'\x30\x82\xff\xff', os.urandom(500), b'\x30' * 100):
        assert 'this is no certificate' in refusal(trust, content)
    assert '20000 is the most' in refusal(trust, b'x' * 20_001)
    assert not trust.rejected()


@pytest.mark.parametrize('days', [(-10, -1), (1, 10)])
def test_a_certificate_out_of_its_time_is_refused(
    pki: Pki, trust: Trust, days: tuple[int, int]
) -> None:
    cert = certificate(days=days)
    put(pki.trusted, cert)
    assert 'it needs a new certificate, or a clock is wrong' in refusal(trust, cert)


def test_short_key_curve_and_missing_uri_are_refused(trust: Trust) -> None:
    short = rsa.generate_private_key(public_exponent=65537, key_size=1024)
    assert 'no RSA key of 2048 to 4096 bits' in refusal(trust, certificate(key=short))
    assert 'has no application URI' in refusal(trust, certificate(uri=''))
    curve = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, 'curve')])
    now = datetime.datetime.now(datetime.timezone.utc)
    made = (
        x509.CertificateBuilder().subject_name(name).issuer_name(name)
        .public_key(curve.public_key()).serial_number(1).not_valid_before(now)
        .not_valid_after(now + datetime.timedelta(days=1)).sign(curve, hashes.SHA256())
    )  # fmt: skip
    assert 'no RSA key' in refusal(trust, made)
    assert not trust.rejected()  # nobody could trust them


# --- what was refused ---------------------------------------------------------------------------


def test_refused_certificate_is_kept_once(trust: Trust) -> None:
    cert = certificate('../../UaExpert@pc\n')
    for _ in range(3):
        message = refusal(trust, cert)
    (kept,) = trust.rejected()
    assert kept.certificate == cert
    assert kept.uri == 'urn:test:client'
    assert f'opcua trust --pki {kept.path.parents[2]} {thumbprint(cert)[:8]}' in message
    assert '\n' not in message
    assert trust.trust(thumbprint(cert)[:8].upper()).certificate == cert
    trust.check(der(cert))


def test_whoever_sends_many_fills_no_disk(trust: Trust, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, 'MOST_REJECTED', 3)
    for number in range(6):
        refusal(trust, certificate(f'client {number}'))
    assert len(trust.rejected()) == 3


def test_certificate_flood_keeps_earlier_one(trust: Trust) -> None:
    honest = certificate('the MES')
    refusal(trust, honest)
    for number in range(2 * module.MOST_REJECTED):
        refusal(trust, certificate(f'client {number}'))
    assert trust.trust(thumbprint(honest)).certificate == honest


def test_a_thumbprint_has_to_be_of_one(trust: Trust) -> None:
    with pytest.raises(NoSuchCertificate, match='there are: none'):
        trust.trust('ab')
    made = [certificate(f'client {number}') for number in range(17)]  # two begin alike
    for entry in made:
        refusal(trust, entry)
    first = [thumbprint(entry)[0] for entry in made]
    twice = next(entry for entry in first if first.count(entry) > 1)
    with pytest.raises(NoSuchCertificate, match='give more of it'):
        trust.trust(twice)
    with pytest.raises(NoSuchCertificate):
        trust.trust('')
    with pytest.raises(NoSuchCertificate, match='that is trusted begins with'):
        trust.remove(thumbprint(made[0]))
    assert not trust.trusted()


# --- authorities --------------------------------------------------------------------------------


def authority(name: str = 'authority') -> tuple[x509.Certificate, rsa.RSAPrivateKey]:
    return certificate(name, key=_AUTHORITY_KEY, is_authority=True), _AUTHORITY_KEY


def revocations(pki: Pki, *revoked: x509.Certificate) -> None:
    """Put a revocation list of the authority into its folder."""
    now = datetime.datetime.now(datetime.timezone.utc)
    builder = (
        x509.CertificateRevocationListBuilder()
        .issuer_name(authority()[0].subject)
        .last_update(now)
        .next_update(now + datetime.timedelta(days=1))
    )
    for cert in revoked:
        builder = builder.add_revoked_certificate(
            x509.RevokedCertificateBuilder()
            .serial_number(cert.serial_number).revocation_date(now).build()
        )  # fmt: skip
    made = builder.sign(_AUTHORITY_KEY, hashes.SHA256())
    (pki.revocations[0] / 'list.crl').write_bytes(made.public_bytes(Encoding.DER))


def test_authority_certificates_are_trusted_until_revoked(pki: Pki, trust: Trust) -> None:
    above = authority()
    cert, other = certificate('found', issuer=above), certificate('other', issuer=above)
    put(pki.trusted, above[0])
    assert 'has no revocation list in trusted/crl or issuers/crl' in refusal(trust, cert)
    revocations(pki)
    trust.check(der(cert))
    (pki.revocations[0] / 'list.crl').unlink()
    revocations(pki, cert)
    assert 'was taken back by its authority' in refusal(trust, cert)
    trust.check(der(other))


def test_an_issuer_alone_is_not_trusted(pki: Pki, trust: Trust) -> None:
    above = authority()
    cert = certificate('found', issuer=above)
    put(pki.issuers, above[0])
    revocations(pki)
    assert 'is not trusted' in refusal(trust, cert)
    put(pki.trusted, cert)
    trust.check(der(cert))


def test_who_is_no_authority_signs_for_nobody(pki: Pki, trust: Trust) -> None:
    client = certificate('a client')
    put(pki.trusted, client)
    cert = certificate('found', issuer=(client, client_key()))
    assert 'is not trusted' in refusal(trust, cert)


def test_the_name_of_an_authority_is_no_proof(pki: Pki, trust: Trust) -> None:
    put(pki.trusted, authority()[0])
    revocations(pki)
    forged = certificate('found', issuer=(authority()[0], client_key()))
    assert 'is not trusted' in refusal(trust, forged)
