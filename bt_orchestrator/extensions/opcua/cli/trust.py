"""`opcua trust`: which clients may connect to the OPC UA servers of this user."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bt_orchestrator.cli.wrong_use import WrongUse

if TYPE_CHECKING:
    from bt_orchestrator.extensions.opcua.server.trust import Listed


def run_trust(pki: Path, given: Sequence[str], *, removes: bool) -> int:
    """List certificates, trust one, or stop trusting it; returns the exit status.

    :param pki: folder of the certificates
    :param given: the beginning of a thumbprint; none: list them
    :raises WrongUse: it is not one thumbprint
    """
    from bt_orchestrator.extensions.opcua.server.pki import Pki
    from bt_orchestrator.extensions.opcua.server.trust import NoSuchCertificate, Trust

    trust = Trust(Pki(pki))
    if not given:
        if removes:
            raise WrongUse(
                'opcua trust --remove: expected the beginning of a thumbprint; '
                'opcua trust alone lists them'
            )
        _list('refused', trust.rejected())
        _list('trusted', trust.trusted())
        return 0
    if len(given) > 1:
        raise WrongUse(
            f'opcua trust: expected one thumbprint, found {" ".join(given)}; name one at a time'
        )
    try:
        found = trust.remove(given[0]) if removes else trust.trust(given[0])
    except NoSuchCertificate as error:
        raise WrongUse(f'opcua trust: {error}') from error
    done = (
        'is no longer trusted; its connections end' if removes else 'is trusted; connect it again'
    )
    print(f'{found.thumbprint} {found.subject} {done}')
    return 0


def _list(what: str, found: Sequence[Listed]) -> None:
    if not found:
        print(f'{what}: none')
        return
    print(f'{what}:')
    for one in found:
        print(
            f'  {one.thumbprint}  {one.since.astimezone():%Y-%m-%d %H:%M}  {_shown(one.subject)}'
        )
        until = one.certificate.not_valid_after_utc
        print(f'    {_shown(one.uri)}, valid until {until:%Y-%m-%d}')


def _shown(text: str) -> str:
    """Return what a client says of itself without what a terminal would do something with."""
    return ''.join(char if char.isprintable() else '?' for char in text)[:200]
