"""The return values of the methods of ISA-95 Job Control (OPC 10031-4, annex B.2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag


class ReturnStatus(IntFlag):
    """A bit map; a call that did what was asked returns DONE alone."""

    DONE = 1
    """The request is done."""
    UNKNOWN_ID = 2
    """There is no such job order."""
    WRONG_STATE = 8
    """The method is not for a job order in its state."""
    NOT_ACCEPTED = 16
    """The order cannot be taken: refused, a duplicate, or the cell is full."""
    MALFORMED = 4294967296
    """The request cannot be understood."""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a request."""

    where: str
    """The field, as JobOrderParameters.RunsPlanned."""
    what: str
    """The expected and the found value."""
    status: ReturnStatus = ReturnStatus.NOT_ACCEPTED

    def __str__(self) -> str:
        return f'{self.where}: {self.what}'


class Unfit(ValueError):
    """A request with findings, which is not sent to the cell."""

    def __init__(self, findings: tuple[Finding, ...]) -> None:
        super().__init__('; '.join(map(str, findings)))
        self.findings = findings

    @property
    def status(self) -> ReturnStatus:
        """All findings together."""
        status = ReturnStatus(0)
        for finding in self.findings:
            status |= finding.status
        return status
