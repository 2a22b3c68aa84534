"""Reading a journal, with or without a running orchestrator (formats: events)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import replace

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model.keeping.books import KeptScript, KeptState, ReasonPage, SlotPage
from bt_orchestrator.model.keeping.records import (
    Damage,
    Extent,
    JobPlace,
    RecordPage,
    Summaries,
    Wanted,
)
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.shared import books, rows, snapshots
from bt_orchestrator.store.shared.database import Database, History, history_of, kept_from
from bt_orchestrator.store.shared.mark import Reached


class KeptRecords(ABC):
    """A journal in a database, read-only and without its lock. Implements `ports.Records`."""

    _name: str
    """The journal, as a user calls it."""
    _terms: rows.Terms

    @abstractmethod
    def _one_moment(self) -> AbstractContextManager[Database]:
        """Read the journal in its present state, unaffected by later writes.

        :raises JournalUnusable: it cannot be read
        """

    @abstractmethod
    def _reached(self) -> Reached | None:
        """Return how far it was written, as far as this machine knows."""

    def _cut_off(self) -> Iterable[Damage]:
        """Report that it may be incomplete, where this machine has no mark of it."""
        return ()

    def extent(self) -> Extent:
        """Return the range of events in it.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            return Extent(self._history(database)[0].id, *self._ends(database))

    def page(self, wanted: Wanted, most: int = rows.MOST) -> RecordPage:
        """Return the next wanted records.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            history, unknown = self._history(database)
            first, last = self._ends(database)
            low = max(wanted.after_seq + 1, first)
            high = last if wanted.before_seq is None else min(wanted.before_seq - 1, last)
            look = rows.Look(wanted, low, high, most)
            look.through(database, self._terms, history.checked_from)
        damage = [*unknown, *map(self._left_out, look.damaged)]
        if high >= last if wanted.newest_first else look.is_last:
            damage += self._gone(history.id)
        return RecordPage(history.id, first, look.found, damage, look.rest, look.is_last)

    def summaries(
        self,
        after: JobPlace | None = None,
        most: int = rows.MOST,
        *,
        newest_first: bool = False,
    ) -> Summaries:
        """Return the summaries of jobs that ended.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            page = rows.summary_page(
                database, after, max(1, min(most, rows.MOST)), newest_first=newest_first
            )
        where = f'in the journal {self._name}'
        damage = [loss._replace(what=f'{loss.what} {where}') for loss in page.damage]
        return replace(page, damage=damage)

    def state_before(self, seq: int) -> Snapshot | None:
        """Return the newest sound state at an event or before it; None: there is none.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            return snapshots.state_before(database, seq)

    def booked(
        self,
        begin_us: int,
        end_us: int,
        most: int = rows.MOST,
        *,
        newest_first: bool = False,
    ) -> SlotPage:
        """Return the slots of the account that lie between two moments, or touch what does.

        :raises JournalUnusable: it cannot be read
        """
        most = max(1, min(most, rows.MOST))
        with self._one_moment() as database:
            page = books.slots(database, begin_us, end_us, most, newest_first=newest_first)
        where = f'in the journal {self._name}'
        return replace(page, damage=[Damage(f'{loss.what} {where}') for loss in page.damage])

    def book_state(self, at_us: int, first_seq: int = 0) -> KeptState | None:
        """Return the newest sound state of the account that is not after a moment.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            return books.states(database, at_us, first_seq)

    def book_script(self, digest: str) -> KeptScript | None:
        """Return a script whose work is in the journal; None: it is missing, or damaged.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            return books.script(database, digest)

    def book_reasons(self, after_seq: int = 0, most: int = rows.MOST) -> ReasonPage:
        """Return the reasons of stops that were given after an event, as far as books go.

        :raises JournalUnusable: it cannot be read
        """
        with self._one_moment() as database:
            page = books.reasons(database, after_seq, max(1, min(most, rows.MOST)))
        where = f'in the journal {self._name}'
        return replace(page, damage=[Damage(f'{loss.what} {where}') for loss in page.damage])

    # --- its own data -----------------------------------------------------------------------

    def _history(self, database: Database) -> tuple[History, list[Damage]]:
        try:
            return history_of(database), []
        except ValueError as error:
            what = f'{error} in the journal {self._name}: no node will start with it'
            return UNKNOWN, [Damage(what)]

    def _ends(self, database: Database) -> tuple[int, int]:
        """Return the seq of the first event that must be there, and of the last one."""
        return kept_from(database), rows.last_seq(database)

    # --- missing data -----------------------------------------------------------------------

    def _left_out(self, damaged: DamagedRecord) -> Damage:
        return Damage(
            f'{damaged} in the journal {self._name}, and left out here; a backup may have what it '
            'was',
            damaged.last + 1 - damaged.first,
        )

    def _gone(self, history: str) -> Iterator[Damage]:
        """Compare the end with the mark, which is written after each commit."""
        reached = self._reached()
        if reached is None:
            yield from self._cut_off()
            return
        if reached.history != history:
            return
        with self._one_moment() as database:
            query = 'SELECT coalesce(max(seq), 0) FROM beginning'
            last = max(rows.last_seq(database), database.execute(query).fetchone()[0])
        if reached.seq > last:
            yield Damage(
                f'the journal {self._name} ends with event {last}, and event {reached.seq} had '
                'been written: what is between is not in it any more',
                reached.seq - last,
            )


UNKNOWN = History('', False, 1 << 62)
"""Of a journal that does not say which; each of its rows may be without a check."""
