"""What an attack is, and what the line may cost meanwhile."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from attack.peer import Peer


@dataclass(frozen=True)
class Bounds:
    """What is allowed while an attack lasts, beyond what the line had when it began."""

    peak_mb: float = 100.0
    """Memory of the node, at any moment."""
    grown_mb: float = 40.0
    """The same at the end."""
    journal_mb: float = 8.0
    """Half of it is what SQLite keeps beside the file until it is tidied up."""
    journal_mb_a_task: float = 0.0
    """What each task of the line may add to that: a result is kept as it came."""
    stalls_s: float = 0.0
    """How long the node cannot answer, whatever it does: it is stopped."""
    plain_too: bool = False
    """The plain node is attacked in the same way, not at the same moment: a ping of the node may
    take as long as the longest of the plain one's."""
    breaks_journal: bool = False
    """The journal cannot be written any more; the node is started again after it."""


class Attack:
    """One way to hurt a line; the first line of its docstring says which.

    :cvar in_short: whether the short form does it
    """

    name: ClassVar[str]
    bounds: ClassVar[Bounds] = Bounds()
    in_short: ClassVar[bool] = True

    def run(self, peer: Peer) -> None:
        """Attack for as long as the peer has time, and complain of what must not be."""
        raise NotImplementedError
