"""The versions of asyncua that this fits: its inside is overridden, others are not guarded."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

from bt_orchestrator.base.errors import OrchestratorError

FITS = '2.1.'


class OpcUaUnusable(OrchestratorError):
    """The packages of the OPC UA server are missing, or do not fit; says what to install."""


def check_version() -> None:
    """Refuse to go on with an asyncua that this was not tried with.

    :raises OpcUaUnusable: says which one was expected, and which one found
    """
    try:
        found = version('asyncua')
    except PackageNotFoundError:
        found = 'none'
    if not found.startswith(FITS):
        raise OpcUaUnusable(
            f'asyncua {FITS}x is needed, and {found} is installed; the server overrides parts of '
            "it, and was tried with that one only; install it with: pip install 'asyncua==2.1.*'"
        )
