"""Errors that a caller can handle."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any


class OrchestratorError(Exception):
    """Base of all errors that this package raises on purpose."""


@dataclass(frozen=True, order=True)
class Finding:
    """One mistake in a file, with its place and a hint.

    Lines and columns count from 1, as editors do. A finding about a file as a whole (it cannot be
    read, say) has line 1, column 1.
    """

    file: str
    line: int
    column: int
    what: str
    hint: str = ''
    key: str = field(default='', compare=False)
    """Of a work order, what it is about, as bind.insert; empty: its place tells."""

    def __str__(self) -> str:
        text = f'{self.file}:{self.line}:{self.column}: {self.what}'
        return f'{text}; {self.hint}' if self.hint else text


def counted(number: int, what: str) -> str:
    """Return a number with the singular or plural of what is counted."""
    return f'{number} {what}' if number == 1 else f'{number} {what}s'


_TOLD, _LONGEST = 3, 300
"""For `in_short`: the number of mistakes shown, and the maximum characters of each."""


class Refused(OrchestratorError):
    """A file was refused; carries every mistake that was found, in the order of the file."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = tuple(findings)
        super().__init__('\n'.join(str(finding) for finding in self.findings))

    def __reduce__(self) -> tuple[Any, Any]:
        """Make it picklable: by default an exception is rebuilt from its text alone."""
        return Refused, (self.findings,)

    @property
    def count(self) -> str:
        """How many mistakes there are, in words."""
        return f'refused with {counted(len(self.findings), "finding")}'

    @property
    def in_short(self) -> str:
        """The number of mistakes, and the first of them without their hints."""
        first = self.findings[:_TOLD]
        places = [
            f'{finding.file}:{finding.line}:{finding.column}: {finding.what}' for finding in first
        ]
        more = len(self.findings) - len(first)
        rest = [f'and {more} more'] if more else []
        texts = (textwrap.shorten(place, _LONGEST, placeholder=' …') for place in places)
        return f'{self.count}: {"; ".join([*texts, *rest])}'


class UnknownActionType(OrchestratorError):
    """An action or message type cannot be loaded here."""

    def __init__(self, type_name: str, what: str, hint: str) -> None:
        self.type_name = type_name
        self.what = what
        self.hint = hint
        super().__init__(f'{what}; {hint}')


class JournalUnusable(OrchestratorError):
    """The journal cannot be opened, or cannot be read as a whole; nothing in it was changed."""


class DatabaseAway(JournalUnusable):
    """The database with the journal cannot be reached, or ended the connection: it may return."""


class JournalAway(OrchestratorError):
    """A journal that several machines can reach cannot be written: the node has to end.

    Another node may go on; this one may be started again.
    """


class JournalFailed(OrchestratorError):
    """Events could not be made durable; their effects were not carried out."""


class DamagedRecord(OrchestratorError):
    """An event in the journal is damaged; the events before it are intact."""

    def __init__(self, first: int, last: int, what: str) -> None:
        """Name the events that cannot be read.

        :param what: the kind of damage, in a word or two
        """
        self.first = first
        self.last = last
        which = f'the record of event {first} is'
        if last > first:
            which = f'the records of events {first} to {last} are'
        super().__init__(f'{which} {what}')


class JournalMismatch(OrchestratorError):
    """The journal's unfinished work does not fit the configured cell."""


class CommandRefused(OrchestratorError):
    """A command cannot be carried out now; the message is the answer to its sender."""

    def __init__(self, message: str, each: Sequence[str] = ()) -> None:
        """Refuse.

        :param each: one message per job, for a command about several jobs
        """
        super().__init__(message)
        self.each = tuple(each)


class NotRead(OrchestratorError):
    """Orders could not be read; the message says why, and what to do."""


class MissingResult(OrchestratorError):
    """A reference names no value that could be used for this item.

    semantics 6.3: the task was skipped or failed, or its result has NaN or infinity there. The
    attempt ends with the reason `missing_result`.
    """

    def __init__(
        self,
        reference: str,
        why: str = 'has no value: that task gave no result for this item',
    ) -> None:
        self.reference = reference
        super().__init__(f'${{{reference}}} {why}')


class NodeUnreachable(OrchestratorError):
    """No tree node answers under the name given, or it cannot tell what was asked."""


class NotKept(OrchestratorError):
    """A past state is not available: its events are removed from the journal, or not yet in it."""
