"""The maker of the books of a journal."""

from __future__ import annotations

from typing import Protocol

from bt_orchestrator.model.books import Books
from bt_orchestrator.ports.writing import Writing


class Bookkeeping(Protocol):
    """Makes the account of a journal in slots of time, outside the tick thread."""

    def begin(self) -> Writing[Books]:
        """Begin to make the next books: from some events after those that are in books.

        Its result raises `ChildFailed` or `JournalUnusable`; then nothing was made.
        """

    def close(self) -> None:
        """Stop working."""
