"""The orchestrator: one settle after another, for real and virtual cells alike.

A settle is: drain commands and news into events, tick the tree until nothing changes, commit all
events as one transaction, then send the goals and hand the events to the outputs (architecture,
"One settle"). Live, recovery, simulation and checking all run this same code.

A commit that takes longer than a moment is left pending: until it ends nothing is landed, ticked
or sent, and the thread is free for readers. Then the settle continues where it stopped.
"""

from __future__ import annotations

import itertools
import logging
import uuid
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from bt_orchestrator.base.errors import JournalFailed, OrchestratorError
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.runtime import job_queue, lifecycle
from bt_orchestrator.engine.runtime.commits import PATIENCE_S, Breakdown, Commits
from bt_orchestrator.engine.runtime.deciding import not_allowed
from bt_orchestrator.engine.runtime.flights import CARRIED_OUT, Flights
from bt_orchestrator.engine.runtime.inbox import Inbox
from bt_orchestrator.engine.runtime.ledger import Ledger, Notice
from bt_orchestrator.engine.runtime.lifecycle import Starvation
from bt_orchestrator.engine.runtime.orders import Starts
from bt_orchestrator.engine.runtime.permits.manual import Panel
from bt_orchestrator.engine.runtime.permits.surroundings import restarted
from bt_orchestrator.engine.runtime.recovery import Found, restore, take_over
from bt_orchestrator.engine.runtime.writers import WritesAtOnce
from bt_orchestrator.engine.tree.blackboard import BlackboardProjection
from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import text_of
from bt_orchestrator.model.commands import Answer, Command, cancels_all
from bt_orchestrator.model.goal import NOT_HEARD
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.waits.waiting import unready
from bt_orchestrator.ports import ActionGateway, Clock, EventSink, EventStore, Worker, Writer

log = logging.getLogger(__name__)

_instances = itertools.count(1)

READ_BACK_S = 5.0
"""How long an engine that stops waits for the state that is in the journal."""

MOST_TICKS = 100_000
"""More ticks than this in one settle are a defect of the rules, not a busy line."""


class Orchestrator:
    """Runs one cell. Every call comes from one thread, the tick thread."""

    def __init__(
        self,
        cell: Cell,
        gateway: ActionGateway,
        clock: Clock,
        store: EventStore,
        sinks: Sequence[EventSink] = (),
        *,
        writer: Writer | None = None,
        reader: Worker | None = None,
        patience_s: float = PATIENCE_S,
        wake: Callable[[], None] = lambda: None,
        auto_start: bool = True,
        auto_resume: bool = False,
        to_remote: bool = False,
        new_goal_id: Callable[[], str] = lambda: str(uuid.uuid4()),
    ) -> None:
        """Build the engine of a cell; nothing moves before the first settle.

        :param writer: waits for the store; None: the thread that settles
        :param reader: the same for readings, while the writer may hang
        :param patience_s: a commit that takes longer counts as failed
        :param wake: requests a settle soon; called whenever there is something new
        :param auto_start: the cell resets and starts by itself when an order arrives
        :param auto_resume: unfinished work in the journal goes on without `Resume`
        :param to_remote: a line in local is in remote again
        :raises JournalMismatch: the journal is of another cell
        """
        self.state = restore(cell, store)
        for script in self.state.scripts.values():  # takes long, and no client is served yet
            script.work_out()
            text_of(script)
        self._store = store
        self._projection = BlackboardProjection(_space(cell), self.state)
        self._sinks: list[EventSink] = [self._projection, *sinks]
        self._auto_start = auto_start
        self._wake = wake
        self._ledger = Ledger(
            self.state, clock, self._notices, new_goal_id, gateway, self._on_time
        )
        self._inbox = Inbox(self._ledger)
        self._starts = Starts(self._ledger)
        self._panel = Panel(self._ledger)
        self._starvation = Starvation(self._ledger)
        self.flights = Flights(self._ledger, gateway, clock, wake, store)
        self.gateway = gateway
        self.tree = CellTree(self._ledger, self._projection.space)
        self._reader = reader or WritesAtOnce()
        writer = writer or WritesAtOnce()
        self._commits = Commits(store, writer, clock, wake, patience_s, self.flights.prepare)
        self._settling = False
        self._look_for_ends = True
        """An event has occurred that may have ended a job."""
        self._look_at_mode = True
        """An event has occurred that may change the state of the cell, or the cell is still."""
        self.breakdown: Breakdown | None = None
        """The remaining functions once the journal could not be written."""
        gateway.listen(wake)
        up = clock.uptime()
        boot = up.boot if up is not None else ''
        journal = Found.of(self.state, store)
        self._ledger.look_back()
        self._ledger.record(
            take_over(self.state, journal, boot, auto_resume=auto_resume, to_remote=to_remote)
        )

    def ask(self, command: Command) -> Answer:
        """Carry out a command, settle, and return the answer; for journals without wait."""
        return begin(self.carry_out(command)).value

    async def carry_out(self, command: Command) -> Answer:
        """Carry out a command, settle, and return the answer for its sender once it is on disk.

        While a commit is pending a command waits for its turn. A command that cancels every goal
        does so at once, and again in its turn, which records the reason.
        """
        heard = self._panel.hear(command) if self.breakdown is None else None
        if heard is not None:
            return heard
        must_wait = self.awaits_disk or self._commits.is_owed
        if must_wait and cancels_all(command) and self._allows(command):
            self.flights.cancel_all()
        await self._commits.turn()
        if self.breakdown is None:
            answer = self._inbox.take(command)
            self.settle()  # a refusal, too, is recorded before its sender gets it
            await self._commits.kept()
        return answer if self.breakdown is None else self._without_journal(command)

    @property
    def awaits_disk(self) -> bool:
        """Tell whether a commit is pending: the state may be ahead of the journal."""
        return self._commits.is_pending

    @property
    def disk_wait(self) -> str:
        """The wait for the disk, in words; empty: nothing waits."""
        return self._commits.in_words

    @property
    def disk_wait_s(self) -> float:
        """How long the commit has waited for the disk, seconds."""
        return self._commits.waited_s

    @property
    def kept_seq(self) -> int:
        """The last event that is durable."""
        return self.state.seq - len(self._commits.events)

    @property
    def broken(self) -> str | None:
        """Why the engine has stopped: the journal could not be written."""
        return None if self.breakdown is None else self.breakdown.message

    @property
    def awaits_ends(self) -> bool:
        """Tell whether there are goals without an end."""
        return bool(self.state.running if self.breakdown is None else self.breakdown.in_flight)

    def add_sink(self, sink: EventSink) -> None:
        """Add an output for events, from the next commit on."""
        self._sinks.append(sink)

    def settle(self) -> bool:
        """Take in commands and news, and let the cell react until nothing changes.

        :return: whether anything happened
        """
        if self.breakdown is not None:
            if self._commits.is_owed:
                self._commits.hand_out()
            self.breakdown.look()
            return False
        assert not self._settling, 'settle was called from within a settle'
        is_unsafe = self.gateway.unsafe not in ('', NOT_HEARD)
        if self.awaits_disk and (is_unsafe or self._panel.is_silent):
            self.flights.cancel_all()  # the record of the loss follows
        went_on = self.awaits_disk
        if (went_on or self._commits.is_owed) and not self._go_on():
            return False
        self._settling = True
        try:
            self._ledger.look_at_clock()
            self.flights.land()
            if self.state.setups:
                self._ledger.record(restarted(self.state, self.gateway))
            self._inbox.land()
            self._starts.land()
            self._panel.land()
            if self.tree.is_due or self._ledger.has_pending:
                self._tick_until_still()
            return self._commit() or went_on
        finally:
            self._settling = False

    def close(self) -> None:
        """Give up the engine; goals in flight stay unchanged."""
        self._ledger.close()
        self.flights.close()
        self.tree.close()
        self._projection.close()

    def _allows(self, command: Command) -> bool:
        return not_allowed(command) is None

    def _without_journal(self, command: Command) -> Answer:
        """Answer a command that cannot be recorded; permissions apply as always."""
        assert self.breakdown is not None
        why_not = not_allowed(command)
        if why_not is not None:
            return Answer(accepted=False, message=why_not)
        return self.breakdown.answer(command)

    def _notices(self, kind: type[e.Event]) -> Iterator[Notice]:
        """Yield what takes note of each event of a class."""
        yield from self.tree.notices(kind)
        if issubclass(kind, e.TaskEvent):
            yield self._note_task
        elif kind in lifecycle.LAST_OF_A_JOB:
            yield self._note_end
        if kind not in lifecycle.OF_THE_LINE:
            yield self._note_mode

    def _note_task(self, event: e.TaskEvent) -> None:
        if event.section is None and event.job is not None:  # initialization
            self._look_for_ends = True

    def _note_end(self, _: e.Event) -> None:
        self._look_for_ends = True

    def _note_mode(self, _: e.Event) -> None:
        self._look_at_mode = True

    def _on_time(self) -> None:
        self.tree.notice_time()
        self._wake()

    def _tick_until_still(self) -> None:
        for _ in range(MOST_TICKS):
            self.tree.tick()
            self._live_on(quiet=not self.tree.is_due)
            if not self.tree.is_due:
                return
        raise AssertionError(f'the tree still changes the state after {MOST_TICKS} ticks')

    def _live_on(self, *, quiet: bool) -> None:
        """Let jobs end and the cell change its state, between ticks.

        :param quiet: another tick would decide nothing
        """
        if self._look_for_ends:
            self._look_for_ends = False
            for ended in lifecycle.jobs_ended(self.state):
                self._ledger.record([*lifecycle.clear_oldest(self.state), ended])
                self.tree.prune(ended.job)
        if self.state.running and not self._look_at_mode:
            return
        is_still = lifecycle.is_still(self.state, self._ledger.is_delayed, quiet=quiet)
        self._look_at_mode = is_still
        if is_still:
            self._ledger.record(job_queue.stop_when_empty(self.state))
        outlook = self._outlook(is_still=is_still)
        reason = lifecycle.stop_reason_change(self.state, outlook)
        if reason is not None:
            self._ledger.record([reason])
        due = lifecycle.next_mode(self.state, outlook, auto_start=self._auto_start)
        if due is not None:
            self._ledger.record([due])

    def _outlook(self, *, is_still: bool) -> lifecycle.Outlook:
        if not is_still:
            return lifecycle.Outlook(still=False, unready=False, starved=self._starvation.look(()))
        waits = list(self._waits_for_readiness())
        waited_for = () if self.state.holds else waits
        return lifecycle.Outlook(True, bool(waits), self._starvation.look(waited_for))

    def _waits_for_readiness(self) -> Iterator[e.TaskKey]:
        state = self.state
        if not state.contests and all(reading.ready for reading in state.readings.values()):
            return  # at rest this is called at every heartbeat
        yield from unready(state, self._ledger)

    def _commit(self) -> bool:
        events = self._ledger.take_pending()
        if not events:
            return False
        self._commits.begin(events)
        self._conclude()
        return self.breakdown is None

    def _go_on(self) -> bool:
        """Conclude the pending commit if it has ended; tell whether the settle may go on."""
        self._settling = True
        try:
            has_ended = not self.awaits_disk or self._conclude()
        finally:
            self._settling = False
        if has_ended:
            self._commits.hand_out()
        return not self.awaits_disk and self.breakdown is None

    def _conclude(self) -> bool:
        """Do what follows from a commit that has ended: send goals, publish events.

        :return: whether it has ended, successfully or not
        """
        if not self._commits.has_ended():
            return False
        events = self._commits.events
        try:
            self._commits.end()
        except JournalFailed as failed:
            self._break_off(failed, events)
            return True
        for event in events:
            if type(event) in CARRIED_OUT:
                self.flights.follow(event)
        for sink in self._sinks:
            self._hand_on(sink, events)
        return True

    def _break_off(self, failed: JournalFailed, lost: Sequence[e.Event]) -> None:
        reading = self._reader.begin(partial(restore, self.state.cell, self._store))
        try:
            if not reading.has_ended(READ_BACK_S):
                raise JournalFailed('it does not answer')
            durable = reading.result()
        except OrchestratorError as error:
            log.error('the state shown may be ahead of the journal: %s', error)
        else:
            # All readers share this object, and must see nothing that is not durable.
            vars(self.state).update(vars(durable))
        # The cell is Held; this is the one shown fact that cannot be recorded.
        self.state.packml, self.state.packml_since = PackmlState.HELD, self._ledger.now
        self.state.stop_reason, self.state.stop_message = StopReason.OWN_FAULT, str(failed)
        for event in lost:
            if isinstance(event, e.OrchestratorStarted):
                self.flights.follow(event)  # sends nothing, and lets `abort` cancel its goals
        if self.state.unit_mode is UnitMode.MANUAL:
            self.flights.cancel_all()  # its panel cannot be watched any more
        self.flights.close()
        self.breakdown = Breakdown(str(failed), self.flights.without_end, self.gateway)
        log.error('%s', self.broken)

    def _hand_on(self, sink: EventSink, events: Sequence[e.Event]) -> None:
        try:
            sink.publish(events)
        except Exception:
            log.exception('output %s failed', type(sink).__name__)


def _space(cell: Cell) -> str:
    """Name a place on the blackboard, which all engines of the process share."""
    number = next(_instances)
    return f'/{cell.name}' if number == 1 else f'/{cell.name}_{number}'
