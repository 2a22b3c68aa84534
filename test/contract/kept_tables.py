"""Journals with the tables of `store/shared`, for the contract of readers: written and damaged."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager

from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.keeping.books import Books, KeptScript, KeptSlot, KeptState
from bt_orchestrator.ports import Journal, Records, Snapshot


class DamagedTables(ABC):
    """Tables that a damaged disk can change."""

    @abstractmethod
    def change(self, statement: str) -> None:
        """Do what a damaged disk does."""

    def spoil(self, seq: int) -> None:
        self.change(f"UPDATE events SET record = replace(record, '{seq}', '7') WHERE seq = {seq}")

    def lose(self, first: int, last: int) -> None:
        self.change(f'DELETE FROM events WHERE seq BETWEEN {first} AND {last}')

    def spoil_book(self, begin_us: int) -> None:
        self.change(f"UPDATE book_slots SET slot = '{{}}' WHERE begin_us = {begin_us}")
        newest = '(SELECT max(seq) FROM book_states)'
        self.change(f"UPDATE book_states SET state = '{{}}' WHERE seq = {newest}")
        self.change("UPDATE book_scripts SET script = 'x'")

    def spoil_summary(self, job: str) -> None:
        self.change(f"UPDATE jobs SET summary = replace(summary, '3', '4') WHERE job = '{job}'")


class WrittenTables(DamagedTables):
    """A journal, and who reads it; between two writes no node has it."""

    records: Records

    @abstractmethod
    def node(self) -> AbstractContextManager[Journal]:
        """Give the journal as a node has it."""

    def append(self, events: Sequence[Event]) -> None:
        with self.node() as store:
            store.append(events)

    def save(self, ended: Sequence[JobRecord]) -> None:
        last = self.records.extent().last_seq
        with self.node() as store:
            store.save(Snapshot(last, 'stamp', '{}'), ended)

    def remove(self, before: int) -> None:
        with self.node() as store:
            store.begin_with(Snapshot(before - 1, 'stamp', '{}'))
            while store.remove_batch(before):
                pass

    def book(self, slots: Sequence[KeptSlot], states: Sequence[KeptState]) -> None:
        history = self.records.extent().history
        scripts = [KeptScript('digest', '{}')]
        with self.node() as store:
            store.keep_books(Books(history, 0, True, slots, states, scripts))
