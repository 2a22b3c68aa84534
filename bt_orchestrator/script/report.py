"""Collecting all mistakes of one file, and guessing what was meant."""

from __future__ import annotations

import difflib
from bisect import bisect
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.words import sentence


@dataclass(frozen=True, order=True)
class Place:
    """A place in a text; both count from 1."""

    line: int
    column: int


START = Place(1, 1)
"""The place of findings about a file as a whole."""


MOST_FINDINGS = 10_000
"""Mistakes after which the reading of a file ends."""

MOST_COMPARED = 400
"""Names that a misspelt one is compared with; a file with thousands may misspell them all."""


class Report:
    """All mistakes of one file.

    Every mistake is reported once, where it was made; a check whose facts could not be read keeps
    silent, so that no mistake is followed by another one that it caused.
    """

    def __init__(self, file: str) -> None:
        self.file = file
        self._findings: set[Finding] = set()

    def add(self, place: Place, what: str, hint: str) -> None:
        """Report a mistake: what is wrong, in one sentence, and what to do about it.

        :raises Refused: there are so many of them that reading on is of no use
        """
        self.keep(Finding(self.file, place.line, place.column, what, hint))

    def keep(self, finding: Finding) -> None:
        """Report a mistake that has its place.

        :raises Refused: there are so many of them that reading on is of no use
        """
        self._findings.add(finding)
        if len(self._findings) >= MOST_FINDINGS:
            words = f'reading ended here, with {MOST_FINDINGS} mistakes'
            end = replace(finding, file=self.file, what=words, hint='mend these first')
            raise Refused([*self.findings, end])

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All mistakes, in the order of the file."""
        return tuple(sorted(self._findings))

    def take(self, findings: Iterable[Finding]) -> None:
        """Take over mistakes that were found before."""
        self._findings.update(findings)

    def refuse(self) -> None:
        """End the reading if there was any mistake.

        :raises Refused: with all of them
        """
        if self._findings:
            raise Refused(self.findings)


def nearest(name: str, known: Iterable[str], likeness: float = 0.6) -> str | None:
    """Return the known name that is most like the given one; None if none is near."""
    return _nearest(name.lower(), tuple(known), likeness)


def did_you_mean(name: str, known: Iterable[str], otherwise: str) -> str:
    """Offer the nearest known name, else say something else."""
    near = nearest(name, known)
    return sentence('did_you_mean', name=near) if near else otherwise


def listing(names: Iterable[str], longest: int = 12) -> str:
    """List names for a message; a long list is cut."""
    all_names = list(names)
    shown = [f'`{name}`' for name in all_names[:longest]]
    return ', '.join(shown) + (', ...' if len(all_names) > longest else '')


@lru_cache(maxsize=4096)
def _nearest(name: str, known: tuple[str, ...], likeness: float) -> str | None:
    by_lower = {candidate.lower(): candidate for candidate in known}
    candidates = _alike(name, known) if len(known) > MOST_COMPARED else by_lower
    near = difflib.get_close_matches(name[:200], candidates, n=1, cutoff=likeness)
    return by_lower[near[0]] if near else None


def _alike(name: str, known: tuple[str, ...]) -> list[str]:
    """Return the names that begin or end most like a name: comparing with all takes too long."""
    begins, ends = _in_order(known)
    around = MOST_COMPARED // 4
    at, at_end = bisect(begins, name), bisect(ends, name[::-1])
    near_ends = (end[::-1] for end in ends[max(0, at_end - around) : at_end + around])
    return [*begins[max(0, at - around) : at + around], *near_ends]


@lru_cache(maxsize=16)
def _in_order(known: tuple[str, ...]) -> tuple[list[str], list[str]]:
    lower = [word.lower() for word in known]
    return sorted(lower), sorted(word[::-1] for word in lower)
