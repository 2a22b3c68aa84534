"""Leader and standby: two nodes of one cell, and one journal in a database (semantics 9.4)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence

from bt_orchestrator.base.errors import JournalAway, JournalFailed, OrchestratorError
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import Journal, Seen, StandbyJournal, Writer, Writing
from bt_orchestrator.ros.actions.gateway import RosGateway
from bt_orchestrator.ros.executor.heart import Pulse

TRY_S = 0.1
"""Time between two attempts to take over."""

LOOK_S = 1.0
"""Time between two looks at the end of the journal."""

COMES_BACK_S = 5.0
"""How long a database has been back before a standby takes over: its leader comes back first."""

WITHOUT_SERVERS_S = 10.0
"""How long a cell has no leader before a standby takes over that does not see all servers."""


class NeverLed(OrchestratorError):
    """The standby was stopped before it led the cell."""


class Standby:
    """Waits until the leader is gone. States: waiting (in `until_it_leads`), then over.

    A thread of its own speaks with the database; the thread of the node sees the servers.
    """

    def __init__(
        self, journal: StandbyJournal, gateway: RosGateway, cell: Cell, pulse: Pulse
    ) -> None:
        self._journal = journal
        self._gateway = gateway
        self._cell = cell
        self._may_take = False
        self._ends = threading.Event()
        self._led_s = time.monotonic()
        """When the cell was led last, as far as is known."""
        self._take_from_s = 0.0
        self._taken: Journal | None = None
        self._failure: OrchestratorError | None = None
        self.seen: Seen | None = None
        """The end of the journal; None: it was not seen yet."""
        self.away = ''
        """Why the journal cannot be seen; empty: it can."""
        pulse.add(self._look_at_servers)

    def until_it_leads(
        self,
        stop: StopSignals,
        spin: Callable[[float], None],
        wake: Callable[[], None],
        ready: Callable[[str], None],
    ) -> Journal:
        """Return the journal once this node is its writer.

        :param spin: lets the node work for so many seconds at most
        :param wake: ends such work, from any thread
        :param ready: is told the leader, once the journal has been seen
        :raises NeverLed: a stop signal came first
        :raises JournalUnusable: no node can go on with this journal
        """
        thread = threading.Thread(target=self._watch, args=(wake,), name='standby', daemon=True)
        self._look_at_servers()
        thread.start()
        is_told = False
        try:
            while self._taken is None and self._failure is None:
                if stop.requested:
                    raise NeverLed('stopped')
                spin(LOOK_S)
                if not is_told and self.seen is not None:
                    is_told = True
                    ready(self.seen.leader)
        finally:
            self._ends.set()
            thread.join()
            self._journal.close()
        if self._failure is not None:
            raise self._failure
        assert self._taken is not None
        self._gateway.begin_anew()
        return self._taken

    @property
    def missing(self) -> Sequence[str]:
        """The action servers that this node does not see."""
        return [
            component.action
            for name, component in self._cell.components.items()
            if not self._gateway.available(name)
        ]

    def _look_at_servers(self) -> None:
        if self._ends.is_set():
            return
        self._gateway.drain()  # what the leader has to know is no matter of this node
        missing, all_of_them = len(self.missing), len(self._cell.components)
        is_long_alone = time.monotonic() - self._led_s >= WITHOUT_SERVERS_S
        self._may_take = not missing or (is_long_alone and missing < all_of_them)

    def _watch(self, wake: Callable[[], None]) -> None:
        try:
            looked_s = -LOOK_S
            while self._taken is None and not self._ends.wait(TRY_S):
                if time.monotonic() - looked_s >= LOOK_S:
                    looked_s = time.monotonic()
                    self._look()
                if self._may_take and not self.away and time.monotonic() >= self._take_from_s:
                    self._take()
        except OrchestratorError as error:
            self._failure = error
        except Exception as error:  # noqa: BLE001 - the node ends with it
            self._failure = JournalAway(f'the standby cannot look at the journal: {error!r}')
        finally:
            wake()

    def _look(self) -> None:
        try:
            seen = self._journal.look()
        except JournalAway as error:
            self._note_away(error)
            return
        self.away = ''
        if seen.is_led:
            self._led_s = time.monotonic()
        self.seen = seen

    def _take(self) -> None:
        try:
            self._taken = self._journal.take()
        except JournalAway as error:
            self._note_away(error)

    def _note_away(self, error: JournalAway) -> None:
        self.away, self._led_s = str(error), time.monotonic()
        self._take_from_s = self._led_s + COMES_BACK_S


class Leading:
    """Keeps the right of a leader to send goals, once a second, and notices that it is gone."""

    def __init__(self, journal: Journal, writer: Writer, pulse: Pulse) -> None:
        """Begin.

        :param writer: waits for the database
        """
        self._journal = journal
        self._writer = writer
        self._renewal: Writing[None] | None = None
        self.lost = ''
        """Why this node has ceased to lead; empty: it leads."""
        pulse.add(self._renew)

    def look(self) -> None:
        """Look whether the last renewal has ended, and how."""
        if self._renewal is None or not self._renewal.has_ended():
            return
        renewal, self._renewal = self._renewal, None
        try:
            renewal.result()
        except JournalFailed as failed:
            self.lost = f'{failed}'

    def _renew(self) -> None:
        self.look()
        if self._renewal is None and not self.lost:
            self._renewal = self._writer.begin(self._journal.renew)
