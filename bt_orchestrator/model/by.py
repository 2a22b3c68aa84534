"""Who asks something of the cell: what the record of every command begins with (semantics 7.1)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class By:
    """Who commands something, from where, and why."""

    who: str
    origin: str
    """Program, interface or computer that the command came from."""
    reason: str

    def __str__(self) -> str:
        return f'{self.who}: {self.reason}'

    def deciding(self, verb: str) -> str:
        """Return a sentence: who decided what, and why."""
        return f'{self.who} decided {verb}: {self.reason}'
