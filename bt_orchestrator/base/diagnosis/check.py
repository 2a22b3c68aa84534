"""One check, its finding, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """How bad it is."""

    OK = 'ok'
    WARN = 'warn'
    """A cell runs, but perhaps not as expected."""
    FAIL = 'fail'
    """A cell does not run."""


@dataclass(frozen=True)
class Check:
    """One line of a diagnosis."""

    name: str
    verdict: Verdict
    found: str
    remedy: str = ''
    """The remedy; only where the check is not ok."""


def ok(name: str, finding: str) -> Check:
    """Return a check that is as it should be."""
    return Check(name, Verdict.OK, finding)


def warn(name: str, finding: str, remedy: str) -> Check:
    """Return a check with a warning."""
    return Check(name, Verdict.WARN, finding, remedy)


def fail(name: str, finding: str, remedy: str) -> Check:
    """Return a check that prevents a cell from running."""
    return Check(name, Verdict.FAIL, finding, remedy)


def worst(checks: Iterable[Check]) -> Verdict:
    """Return the worst verdict of all; nothing is ok."""
    verdicts = {check.verdict for check in checks}
    return next((v for v in (Verdict.FAIL, Verdict.WARN) if v in verdicts), Verdict.OK)
