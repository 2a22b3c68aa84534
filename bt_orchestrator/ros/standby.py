"""Leader and standby: two nodes of one cell, and one journal in a database (semantics 9.4)."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Sequence
from datetime import datetime
from socket import gethostname
from typing import Any

from bt_orchestrator_interfaces.msg import StandbyStatus as StandbyMessage
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from bt_orchestrator.base.errors import JournalAway, JournalFailed, OrchestratorError
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.limits import MESSAGE, PLACE, cut
from bt_orchestrator.model.status import Leadership, StandbyStatus
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import Journal, Seen, StandbyJournal, Writer, Writing
from bt_orchestrator.ros.actions.gateway import RosGateway
from bt_orchestrator.ros.executor.heart import Pulse
from bt_orchestrator.ros.qos import publisher, subscribe
from bt_orchestrator.ros.types.status_messages import standby_message, standby_status

TRY_S = 0.1
"""Time between two attempts to take over."""

LOOK_S = 1.0
"""Time between two looks at the end of the journal."""

COMES_BACK_S = 5.0
"""How long a database has been back before a standby takes over: its leader comes back first."""

WITHOUT_SERVERS_S = 10.0
"""How long a cell has no leader before a standby takes over that does not see all servers."""


TOPIC = 'standby'

REPORTS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)

SILENT_S = 5.0
"""Time after which a standby that reports once a second counts as gone."""

REMEMBERED_S = 3600.0
"""How long a leader warns of a standby that is gone."""

MOST_KNOWN = 7
"""Standbys besides the newest; a peer may invent any number."""


class NeverLed(OrchestratorError):
    """The standby was stopped before it led the cell."""


class Standby:
    """Waits until the leader is gone. States: waiting (in `until_it_leads`), then over.

    A thread of its own speaks with the database; the thread of the node sees the servers.
    """

    def __init__(
        self, node: Node, journal: StandbyJournal, gateway: RosGateway, cell: Cell, pulse: Pulse
    ) -> None:
        self._report = StandbyReport(node, cell)
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
            self._report.close()
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
        self._report.publish(self.trouble, self.seen)

    @property
    def trouble(self) -> str:
        """Why this node could not take over at this moment; empty: it could."""
        if self.away:
            return sentence('standby_away', words=self.away)
        missing = self.missing
        return sentence('standby_servers', actions=', '.join(missing)) if missing else ''

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


class StandbyReport:
    """The health of a standby, which it publishes itself: `~/standby` and `/diagnostics`."""

    def __init__(self, node: Node, cell: Cell) -> None:
        self._node = node
        self._cell = cell
        self._host, self._process = gethostname(), os.getpid()
        self._health = publisher(node, StandbyMessage, f'~/{TOPIC}', REPORTS)
        self._diagnostics = publisher(node, DiagnosticArray, '/diagnostics', 10)

    def publish(self, trouble: str, seen: Seen | None) -> None:
        """Publish whether this node could take over, and what it has seen."""
        seq = seen.seq if seen is not None else 0
        status = StandbyStatus(self._host, self._process, trouble, seq)
        self._health.publish(standby_message(status))
        values = {'host': self._host, 'process': self._process, 'seq': seq}
        if seen is not None:
            values |= {'leader': seen.leader if seen.is_led else '', 'epoch': seen.epoch}
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        name = self._node.get_fully_qualified_name().lstrip('/')
        message.status = [
            DiagnosticStatus(
                level=DiagnosticStatus.WARN if trouble else DiagnosticStatus.OK,
                name=f'{name}: standby {self._host}',
                hardware_id=self._cell.name,
                message=trouble or 'it can take over',
                values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
            )
        ]
        self._diagnostics.publish(message)

    def close(self) -> None:
        """Publish nothing any longer."""
        self._node.destroy_publisher(self._health)
        self._node.destroy_publisher(self._diagnostics)


class Standbys:
    """The nodes that a leader can leave the cell to, as they report themselves."""

    def __init__(self, node: Node, epoch: int, *, wanted: bool) -> None:
        """Begin to listen.

        :param epoch: of this leader
        :param wanted: whether this node has been a standby itself, so another one should be there
        """
        self.wanted = wanted
        self._own = Leadership(gethostname(), os.getpid(), epoch)
        self._heard: dict[tuple[str, int], tuple[StandbyStatus, float]] = {}
        subscribe(node, StandbyMessage, f'~/{TOPIC}', self._hear, REPORTS)

    def leadership(self) -> Leadership:
        """Return this leader with the standbys that were heard within the last hour."""
        now = time.time()
        self._heard = {
            key: entry for key, entry in self._heard.items() if now - entry[1] < REMEMBERED_S
        }
        standbys = (self._told(status, at_s, now) for status, at_s in self._heard.values())
        return changed(self._own, standbys=tuple(standbys))

    def _told(self, status: StandbyStatus, at_s: float, now: float) -> StandbyStatus:
        if now - at_s < SILENT_S:
            return status
        moment = f'{datetime.fromtimestamp(at_s):%H:%M:%S}'
        return changed(status, trouble=sentence('standby_silent', time=moment))

    def _hear(self, message: Any) -> None:
        status = standby_status(message)
        status = changed(
            status, host=cut(status.host, PLACE), trouble=cut(status.trouble, MESSAGE)
        )
        key = (status.host, status.process)
        now = time.time()
        if key not in self._heard:  # a standby that was started anew takes the place of the last
            others = {k: e for k, e in self._heard.items() if k[0] != key[0] or _is_live(e, now)}
            self._heard = dict(list(others.items())[-MOST_KNOWN:])
        self._heard[key] = (status, now)


def _is_live(entry: tuple[StandbyStatus, float], now: float) -> bool:
    return now - entry[1] < SILENT_S


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
