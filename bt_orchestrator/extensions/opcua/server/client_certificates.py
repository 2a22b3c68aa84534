"""The conditions for a good certificate of a client, and its signer."""

from __future__ import annotations

import datetime
from collections.abc import Iterable
from contextlib import suppress

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.x509.oid import ExtendedKeyUsageOID

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.extensions.opcua.server.pki import application_uri

KEY_BITS = range(2048, 4096 + 1)
_HASHES = (hashes.SHA256, hashes.SHA384, hashes.SHA512)


class Untrusted(OrchestratorError):
    """A certificate is refused; says why, and what to do."""


_NEW = 'give the client another certificate'


def check_form(certificate: x509.Certificate, now_s: float) -> None:
    """Refuse what would not be accepted from anybody.

    :param now_s: seconds since 1970
    :raises Untrusted: says why
    """
    who = named(certificate)
    key = certificate.public_key()
    if not isinstance(key, rsa.RSAPublicKey) or key.key_size not in KEY_BITS:
        raise Untrusted(f'{who} has no RSA key of {KEY_BITS[0]} to {KEY_BITS[-1]} bits; {_NEW}')
    if not isinstance(certificate.signature_hash_algorithm, _HASHES):
        raise Untrusted(f'{who} is not signed with SHA-256 or better; {_NEW}')
    check_time(certificate, now_s)
    if not application_uri(certificate):
        raise Untrusted(f'{who} has no application URI (a URI in subjectAltName); {_NEW}')
    if not _may_be_a_client(certificate):
        raise Untrusted(f'{who} is not meant for clients (key usage); {_NEW}')


def check_time(certificate: x509.Certificate, now_s: float) -> None:
    """Refuse what is not valid now.

    :raises Untrusted: says from when to when it is
    """
    now = datetime.datetime.fromtimestamp(now_s, datetime.timezone.utc)
    first, last = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    if not first <= now <= last:
        raise Untrusted(
            f'{named(certificate)} is valid from {first:%Y-%m-%d %H:%M} to '
            f'{last:%Y-%m-%d %H:%M} UTC, and it is {now:%Y-%m-%d %H:%M}; it needs a new '
            'certificate, or a clock is wrong'
        )


def first_of(content: bytes) -> bytes:
    """Return the first certificate of a chain in DER, by its own length."""
    if len(content) >= 4 and content[0] == 0x30 and content[1] == 0x82:
        return content[: 4 + int.from_bytes(content[2:4], 'big')]
    return content


def _may_be_a_client(certificate: x509.Certificate) -> bool:
    extensions = certificate.extensions
    with suppress(x509.ExtensionNotFound):
        usage = extensions.get_extension_for_class(x509.KeyUsage).value
        if not usage.digital_signature:
            return False
    with suppress(x509.ExtensionNotFound):
        purposes = extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
        return ExtendedKeyUsageOID.CLIENT_AUTH in purposes
    return True


def issuer_of(
    certificate: x509.Certificate, others: Iterable[x509.Certificate]
) -> x509.Certificate | None:
    """Return the authority that has signed a certificate; None: it is not known."""
    for authority in others:
        with suppress(ValueError, TypeError, InvalidSignature, x509.ExtensionNotFound):
            certificate.verify_directly_issued_by(authority)
            if authority.extensions.get_extension_for_class(x509.BasicConstraints).value.ca:
                return authority
    return None


def check_revoked(
    certificate: x509.Certificate,
    issuer: x509.Certificate,
    revocations: Iterable[x509.CertificateRevocationList],
) -> None:
    """Refuse a certificate that its authority has taken back, or may have.

    :raises Untrusted: says which
    """
    key = issuer.public_key()
    lists = [
        revocation
        for revocation in revocations
        if revocation.issuer == issuer.subject and revocation.is_signature_valid(key)  # type: ignore[arg-type]
    ]
    if not lists:
        raise Untrusted(
            f'whether {named(certificate)} was taken back is not known: its authority '
            f'{issuer.subject.rfc4514_string()} has no revocation list in trusted/crl or '
            'issuers/crl; put one there, it may be empty'
        )
    if any(
        revocation_list.get_revoked_certificate_by_serial_number(certificate.serial_number)
        for revocation_list in lists
    ):
        raise Untrusted(f'{named(certificate)} was taken back by its authority')


def named(certificate: x509.Certificate) -> str:
    """Return what a certificate is called in messages."""
    uri = application_uri(certificate)
    subject = certificate.subject.rfc4514_string()
    shown_uri = f' ({uri!r:.200})' if uri else ''
    return f'the certificate {thumbprint(certificate)} of {subject!r:.200}{shown_uri}'


def thumbprint(certificate: x509.Certificate) -> str:
    """Return the SHA-1 of a certificate in small letters."""
    return certificate.fingerprint(hashes.SHA1()).hex()
