"""The clients that may connect: certificates in folders, which are read anew when they change."""

from __future__ import annotations

import datetime
import logging
import re
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import NameOID

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.ordinary_file import read_ordinary
from bt_orchestrator.extensions.opcua.server.client_certificates import (
    Untrusted,
    check_form,
    check_revoked,
    check_time,
    first_of,
    issuer_of,
    named,
    thumbprint,
)
from bt_orchestrator.extensions.opcua.server.pki import LARGEST_FILE, Pki, application_uri, parsed
from bt_orchestrator.model.limits import Allowance, Share
from bt_orchestrator.ports.spare_log import SpareLog

_T = TypeVar('_T')

spare = SpareLog(logging.getLogger(__name__))

MOST_REJECTED = 50
"""Refused certificates that are kept; anybody who reaches the port can send another one."""

REJECTED = Share(30, 0.5)
"""How many are kept at once, and a second: whoever sends many pushes out no others in a moment."""

MOST_BYTES = 20_000
"""Longest certificate, or chain of them, that is looked at."""

MOST_ISSUERS = 5
"""Most authorities between a client and a trusted one."""

_SUFFIXES = ('.der', '.crt', '.cer', '.pem')


class NoSuchCertificate(OrchestratorError):
    """No certificate, or several, have this thumbprint; says which there are."""


@dataclass(frozen=True)
class Listed:
    """A certificate in one of the folders."""

    path: Path
    certificate: x509.Certificate
    since: datetime.datetime
    """When it came into the folder."""

    @property
    def thumbprint(self) -> str:
        """SHA-1, in small letters: what OPC UA programs show."""
        return thumbprint(self.certificate)

    @property
    def subject(self) -> str:
        """The name of its owner, for people."""
        return self.certificate.subject.rfc4514_string()

    @property
    def uri(self) -> str:
        """The application URI."""
        return application_uri(self.certificate)


@dataclass(frozen=True)
class _Store:
    """The content of the folders at a time."""

    trusted: Sequence[x509.Certificate]
    issuers: Sequence[x509.Certificate]
    revocations: Sequence[x509.CertificateRevocationList]


class Trust:
    """Decides about certificates of clients; what is trusted or removed counts at once."""

    def __init__(self, pki: Pki, clock: Callable[[], float] = time.time) -> None:
        """Begin with what is in the folders.

        :param clock: seconds since 1970
        """
        self._pki = pki
        self._clock = clock
        self._version: object = None
        self._kept = Allowance(REJECTED)
        self._store = _Store((), (), ())

    @property
    def version(self) -> object:
        """The things that change with the folders."""
        return tuple(map(_changed_at, (self._pki.trusted, self._pki.issuers, *self._crl)))

    def check(self, content: bytes) -> x509.Certificate:
        """Return the certificate of a client that may connect.

        :param content: DER, perhaps followed by those of its authorities
        :raises Untrusted: it may not
        """
        if len(content) > MOST_BYTES:
            raise Untrusted(f'a certificate of {len(content)} bytes; {MOST_BYTES} is the most')
        try:
            certificate = x509.load_der_x509_certificate(first_of(content))
            check_form(certificate, self._clock())
            is_trusted = self._is_trusted(certificate)
        except Untrusted:
            raise
        # Whatever the parser finds in what anybody may send: ASN.1 errors, unknown algorithms.
        except Exception as error:
            raise Untrusted(f'this is no certificate: {str(error)[:200]}') from error
        if not is_trusted:
            self._reject(certificate)
            raise Untrusted(
                f'{named(certificate)} is not trusted; if its thumbprint is what that client '
                f'shows, trust it with: {self._command} {thumbprint(certificate)[:8]}'
            )
        return certificate

    # --- for people -----------------------------------------------------------------------------

    def trusted(self) -> list[Listed]:
        """Return what is trusted, newest first."""
        return _listed(self._pki.trusted)

    def rejected(self) -> list[Listed]:
        """Return what was refused and is not trusted since, newest first."""
        return _listed(self._pki.rejected)

    def trust(self, prefix: str) -> Listed:
        """Trust a certificate that was refused.

        :param prefix: of its thumbprint
        :raises NoSuchCertificate: there is none, or several
        """
        entry = _one_of(self.rejected(), prefix, 'was refused')
        self._move(entry, self._pki.trusted)
        return entry

    def remove(self, prefix: str) -> Listed:
        """Stop trusting a certificate; it can be trusted again.

        :param prefix: of its thumbprint
        :raises NoSuchCertificate: there is none, or several
        """
        entry = _one_of(self.trusted(), prefix, 'is trusted')
        self._move(entry, self._pki.rejected)
        return entry

    @property
    def _command(self) -> str:
        return f'bt-orchestrator opcua trust --pki {self._pki.root}'

    def _move(self, entry: Listed, folder: Path) -> None:
        self._pki.make_folders()
        _write(folder, entry.certificate)
        entry.path.unlink()

    # --- whether --------------------------------------------------------------------------------

    def _is_trusted(self, certificate: x509.Certificate) -> bool:
        """Tell whether it is trusted itself, or an authority that is trusted stands behind it.

        :raises Untrusted: it, or an authority, was taken back or has expired
        """
        store = self._read()
        is_known, link = certificate in store.trusted, certificate
        for _ in range(MOST_ISSUERS):
            if link.issuer == link.subject:
                break
            issuer = issuer_of(link, (*store.trusted, *store.issuers))
            if issuer is None:
                break
            check_time(issuer, self._clock())
            check_revoked(link, issuer, store.revocations)
            is_known, link = is_known or issuer in store.trusted, issuer
        return is_known

    def _reject(self, certificate: x509.Certificate) -> None:
        """Keep a certificate, for somebody to trust; of very many only some."""
        now = time.monotonic()
        if self._kept.left(now) < 1:
            return
        self._kept.use(1, now)
        try:
            self._pki.make_folders()
            _write(self._pki.rejected, certificate)
            for old in _listed(self._pki.rejected)[MOST_REJECTED:]:
                old.path.unlink(missing_ok=True)
        except (OSError, OrchestratorError) as error:
            spare.warning(f'the refused certificate was not kept: {error}')

    # --- the folders ----------------------------------------------------------------------------

    @property
    def _crl(self) -> tuple[Path, Path]:
        return self._pki.revocations

    def _read(self) -> _Store:
        version = self.version
        if version != self._version:
            self._version = version
            revocations = _contents(self._crl, (*_SUFFIXES, '.crl'), _revocation_list)
            certificates = partial(_contents, suffixes=_SUFFIXES, parse=parsed)
            self._store = _Store(
                list(certificates((self._pki.trusted,))),
                list(certificates((self._pki.issuers,))),
                list(revocations),
            )
        return self._store


# --- files --------------------------------------------------------------------------------------


def _changed_at(folder: Path) -> int:
    try:
        return folder.stat().st_mtime_ns
    except OSError:
        return 0


def _files(folder: Path, suffixes: Sequence[str]) -> Iterator[Path]:
    with suppress(OSError):
        yield from (path for path in folder.iterdir() if path.suffix.lower() in suffixes)


def _contents(
    folders: Iterable[Path], suffixes: Sequence[str], parse: Callable[[bytes], _T]
) -> Iterator[_T]:
    for folder in folders:
        for path in _files(folder, suffixes):
            try:
                yield parse(read_ordinary(path, LARGEST_FILE))
            except (OSError, ValueError) as error:
                spare.warning(f'{path} is not used: {str(error)[:200]}')


def _revocation_list(content: bytes) -> x509.CertificateRevocationList:
    if content.lstrip().startswith(b'-----BEGIN'):
        return x509.load_pem_x509_crl(content)
    return x509.load_der_x509_crl(content)


def _listed(folder: Path) -> list[Listed]:
    entries = []
    for path in _files(folder, _SUFFIXES):
        with suppress(OSError, ValueError):
            at = datetime.datetime.fromtimestamp(path.stat().st_mtime, datetime.timezone.utc)
            entries.append(Listed(path, parsed(read_ordinary(path, LARGEST_FILE)), at))
    return sorted(entries, key=lambda entry: entry.since, reverse=True)


def _one_of(listed: Sequence[Listed], prefix: str, what: str) -> Listed:
    wanted = prefix.lower().replace(':', '').replace(' ', '')
    fitting = [entry for entry in listed if wanted and entry.thumbprint.startswith(wanted)]
    if len(fitting) == 1:
        return fitting[0]
    there = ', '.join(entry.thumbprint[:8] for entry in fitting or listed) or 'none'
    if fitting:
        raise NoSuchCertificate(
            f'several certificates begin with {prefix}: {there}; give more of it'
        )
    raise NoSuchCertificate(
        f'no certificate that {what} begins with {prefix!r}; there are: {there}'
    )


def _write(folder: Path, certificate: x509.Certificate) -> None:
    """Write a certificate under a name that tells people which one it is."""
    common = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    shown = re.sub(r'[^\w@.-]', '_', str(common[0].value) if common else 'nobody')[:60]
    path = folder / f'{shown.lstrip(".")} [{thumbprint(certificate)}].der'
    fresh = path.with_suffix('.new')
    fresh.write_bytes(certificate.public_bytes(Encoding.DER))
    fresh.replace(path)
