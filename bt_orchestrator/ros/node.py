"""The tree node: one cell on ROS 2, from its parameters to a clean end."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import rclpy
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier

from bt_orchestrator.base.diagnosis.ros_environment import ros_says
from bt_orchestrator.base.errors import JournalAway, JournalUnusable, OrchestratorError
from bt_orchestrator.base.replies import begin
from bt_orchestrator.base.stop_signals import StopSignals, leaving
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.recipes import QueueAnew, RecipeOrders
from bt_orchestrator.engine.runtime.housekeeping import Housekeeping
from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations, last_events
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview, RosAccess
from bt_orchestrator.engine.runtime.writers import Readings, WriterThread
from bt_orchestrator.model.by import Control
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import FoundTwin, Shutdown
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.keeping.journal_place import JournalPlace
from bt_orchestrator.model.uptime import ClockReading
from bt_orchestrator.ports import (
    Bookkeeping,
    EventSink,
    EventStore,
    Foresight,
    Generating,
    Journal,
    StandbyJournal,
    StopSearch,
)
from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.ros.actions.gateway import RosGateway
from bt_orchestrator.ros.clock import RosClock, clock_reading
from bt_orchestrator.ros.executor.executors import make_executor, soon, spin_once
from bt_orchestrator.ros.executor.heart import Heart, Pulse
from bt_orchestrator.ros.executor.ways import choose_way
from bt_orchestrator.ros.identity import Presence
from bt_orchestrator.ros.inspection.snapshot_source import TickStatistics
from bt_orchestrator.ros.inspection.start import start_inspection
from bt_orchestrator.ros.memory import collect_rarely, give_back, widen_buffers
from bt_orchestrator.ros.node_parameters import BUILTIN, NodeParameters
from bt_orchestrator.ros.parameters import declare
from bt_orchestrator.ros.qos import quieten
from bt_orchestrator.ros.service_manager import ALIVE, READY, STOPPING, is_told, tell, watchdog
from bt_orchestrator.ros.services.expected_ends import ExpectedEnds
from bt_orchestrator.ros.services.order_process import order_process
from bt_orchestrator.ros.services.order_reader import OrderReader
from bt_orchestrator.ros.services.outputs import (
    DescriptionTopic,
    Diagnostics,
    EventsTopic,
    StatusTopic,
)
from bt_orchestrator.ros.services.patient_service import make_all_patient
from bt_orchestrator.ros.services.prompt_profile import prompt_answers
from bt_orchestrator.ros.services.reading_services import EventsService, StateService, serve_lists
from bt_orchestrator.ros.services.run_job import RunJobServer
from bt_orchestrator.ros.services.services import Senders, Services
from bt_orchestrator.ros.standby import Leading, NeverLed, Standby, Standbys
from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.script.cell_file import CELL_FILE, read_cell
from bt_orchestrator.script.shifts.shifts_file import read_reasons

NODE_NAME = 'bt_orchestrator'

FAREWELL_S = 10.0
"""Longest time that a stop waits for the ends of cancelled goals."""

LAST_WORDS_S = 0.3
"""How long the node stays after its last words, for others to hear them."""


class BadRosArguments(OrchestratorError):
    """The words behind --ros-args cannot be understood."""


class NoCell(OrchestratorError):
    """The node was not told which cell it runs."""


Soon = Callable[[Callable[[], None]], None]


class Parts(NamedTuple):
    """The things that other rooms give the node."""

    open_journal: Callable[[JournalPlace, str], Journal]
    """Opens a journal, to be written with a value of `journal_synchronous`."""
    open_standby: Callable[[JournalPlace, Callable[[], ClockReading | None]], StandbyJournal]
    """Opens the journal of a leader; what it is given reads the clocks of this machine."""
    make_memory_store: Callable[[], EventStore]
    """Makes one that is gone with the process, where no file is named."""
    make_foresight: Callable[[Cell], Foresight]
    make_bookkeeping: Callable[[JournalPlace], Bookkeeping]
    """Makes what makes the books of a journal."""
    make_generating: Callable[[Cell, Sequence[Path], Soon], Generating]
    """Makes what generates the scripts of orders by recipe, from recipes in some folders; what it
    is given lets the tick thread call something."""
    make_stop_search: Callable[[JournalPlace, Soon], StopSearch]
    """Makes what looks for stops of the line in a journal."""
    sinks: Sequence[EventSink] = ()
    """Outputs of other packages."""


class TreeNode:
    """A cell's engine with its gateway, services and outputs on one ROS node and one thread."""

    def __init__(
        self,
        node: Node,
        defaults: NodeParameters,
        parts: Parts,
        stop: StopSignals,
        say: Callable[[str], None],
    ) -> None:
        """Read the parameters and the cell file, and wire everything; a standby waits first.

        :param stop: ends the wait of a standby
        :param say: is told that a standby is ready

        :raises NoCell: the parameter `cell` is empty, and this folder has no cell file
        :raises Refused: the cell file or the file of reasons, with every mistake in it
        :raises BadParameter: a parameter is none of its choices
        :raises NoEventsExecutor: the parameter `executor` asks for one that this ROS 2 has not
        :raises TwinFound: another process runs a cell under this name
        :raises NeverLed: the standby was stopped
        :raises KeyUnusable: the parameter `signed_commands` asks for a library that is missing
        :raises NoLibrary: the parameter `inspection` asks for one that cannot be loaded
        """
        self.node = node
        self._log = SpareLog(node.get_logger())
        presence = Presence(node)  # hears others while this one is set up
        self.parameters = declare(node, defaults)
        make_all_patient(node)
        self._senders = Senders(self.parameters, os.environ, get_rmw_implementation_identifier())
        types = InstalledActionTypes()
        self._cell_file = _cell_file(self.parameters)
        cell = read_cell(self._cell_file, types)
        reasons_file = self.parameters.reasons
        self._reasons = None if reasons_file is None else read_reasons(reasons_file)
        way = choose_way(self.parameters.client, node)
        self.executor: Executor = make_executor(self.parameters.executor, way)
        self.heart = Heart(node, self.executor)
        self._gateway = RosGateway(
            node, cell, types, way, server_timeout_s=self.parameters.server_timeout
        )
        pulse = self._pulse = Pulse(node)
        if is_told():  # the thread that ticks says so: a node that stands says nothing
            pulse.add(partial(tell, ALIVE))
        self._durations = ObservedDurations()
        self._journal: Journal | None
        if self.parameters.standby:
            self._journal = self._stand_by(cell, parts, pulse, stop, say)
        else:
            presence.refuse_a_twin()
            self._journal = _open_journal(self.parameters, parts)
        self._writer = WriterThread(self.heart.wake) if self._journal is not None else None
        self._readings = Readings(partial(soon, self.executor))
        self._leading = self._lead(pulse)
        self._standbys = self._hear_standbys()
        store = self._journal or parts.make_memory_store()
        self.orchestrator = self._engine(cell, store, parts.sinks)
        self._overview = Overview(
            self.orchestrator,
            self._durations,
            RosAccess(
                self._senders.unauthenticated, self._senders.signed_commands, self._senders.uptime
            ),
            self._standbys.leadership if self._standbys is not None else lambda: None,
        )
        journal = self.parameters.journal
        self._bookkeeping = None if journal is None else parts.make_bookkeeping(journal)
        later = partial(soon, self.executor)
        self._stops = None if journal is None else parts.make_stop_search(journal, later)
        self._housekeeping = self._keep_house()
        self._expected = self._look_ahead(parts, pulse, store)
        self._order_process = self._read_orders()
        self._generating = self._generate(parts)
        self._orders = RecipeOrders(self._order_process, self._generating, self.orchestrator.state)
        self._take_requests(types, store)
        self._status = self._show(pulse, types)
        self._ticks = TickStatistics()
        self._inspected = start_inspection(
            node, self.orchestrator, self._ticks, self.parameters.inspection
        )
        widen_buffers()
        self.executor.add_node(node)
        presence.announce(
            cell,
            store.history,
            0 if self._journal is None else self._journal.epoch,
            lambda words: begin(self.orchestrator.carry_out(FoundTwin(words))),
        )

    @property
    def ready_line(self) -> str:
        """One line that says what runs under which name."""
        name = self.node.get_fully_qualified_name()
        cell = self.orchestrator.state.cell
        return f'tree node ready: {name} runs cell {cell.name} ({self._cell_file})'

    def serve(self, stop: StopSignals) -> None:
        """Run the cell until a stop signal comes."""
        settle = self._inspected(self._ticks.timed(self.orchestrator.settle))
        rate_hz = self.parameters.tick_rate_hz
        self.heart.start(lambda: self._beat(settle), rate_hz, self._pulse)
        self.heart.beat()  # nobody is told what a take-over has noted before it is kept
        self._status.publish_now()
        tell(READY, f'STATUS={self.ready_line}', watchdog(patient=False))
        while not stop.requested:
            self._spin_once()
            if self._leading is not None:
                self._leave_to_others(self._leading)

    def _leave_to_others(self, leading: Leading) -> None:
        """End if another node may go on with the journal.

        :raises JournalAway: so it is; goals go on to their ends
        """
        why = self.orchestrator.broken or leading.lost
        if why:
            raise JournalAway(why)

    def _stand_by(
        self, cell: Cell, parts: Parts, pulse: Pulse, stop: StopSignals, say: Callable[[str], None]
    ) -> Journal:
        """Wait until this node is the writer of the journal."""
        if self.parameters.journal is None:
            raise JournalUnusable('a standby needs a journal in a database: name it, --journal')
        self.executor.add_node(self.node)
        wake = partial(soon, self.executor, _nothing)
        stop.notify(wake)
        journal = parts.open_standby(self.parameters.journal, clock_reading)
        standby = Standby(self.node, journal, self._gateway, cell, pulse)
        name = self.node.get_fully_qualified_name()

        def ready(leader: str) -> None:
            words = f'standby ready: {name} waits to run cell {cell.name} ({self._cell_file})'
            line = f'{words}, led by {leader}' if leader else words
            tell(READY, f'STATUS={line}')
            say(line)

        taken = standby.until_it_leads(stop, self._spin_once, wake, ready)
        tell(watchdog(patient=True))
        return taken

    def _hear_standbys(self) -> Standbys | None:
        if self._journal is None or not self._journal.is_shared:
            return None
        return Standbys(self.node, self._journal.epoch, wanted=self.parameters.standby)

    def _lead(self, pulse: Pulse) -> Leading | None:
        """Keep the right to lead, if another node can take over."""
        if self._journal is None or self._writer is None or not self._journal.is_shared:
            return None
        self._gateway.obey(self._journal.may_command, self._journal.alone_from_s)
        return Leading(self._journal, self._writer, pulse)

    def finish(self, stop: StopSignals) -> list[str]:
        """Cancel every goal and wait for the ends, not longer than FAREWELL_S.

        :return: the tasks whose goals have not ended, in words
        """
        tell(STOPPING)
        first = stop.count
        answer = begin(self.orchestrator.carry_out(Shutdown()))
        while not answer.is_there and stop.count == first:  # for the journal's timeout at most
            self._spin_once(0.1)
        deadline = time.monotonic() + FAREWELL_S
        while (
            self.orchestrator.awaits_ends and stop.count == first and time.monotonic() < deadline
        ):
            self._spin_once(0.1)
        self._status.publish_now()
        self._linger(lambda: stop.count > first)
        return list(self._without_end())

    def close(self) -> None:
        """Let go of everything."""
        self._expected.close()
        self._generating.close()
        self._order_process.close()
        for work in (self._bookkeeping, self._stops):
            if work is not None:
                work.close()
        if self._housekeeping is not None and self._is_durable:
            self._housekeeping.finish()
        self.orchestrator.close()
        if (
            self._journal is not None
            and self._writer is not None
            and self._readings.close(FAREWELL_S)
            and self._writer.close(FAREWELL_S)
        ):
            self._journal.close()  # or else the end of the process does, if the disk lets it
        with leaving():
            self._gateway.close()
            self.executor.shutdown()
            self.node.destroy_node()

    def _engine(self, cell: Cell, store: EventStore, sinks: Sequence[EventSink]) -> Orchestrator:
        orchestrator = Orchestrator(
            cell,
            self._gateway,
            RosClock(self.node),
            store,
            [self._durations],
            writer=self._writer,
            reader=self._readings,
            patience_s=self.parameters.journal_timeout,
            wake=self.heart.wake,
            auto_start=self.parameters.auto_start,
            auto_resume=self.parameters.auto_resume,
            to_remote=self.parameters.control == Control.REMOTE.value,
        )
        # Not before: where events are missing the take-over begins another history.
        for sink in (EventsTopic(self.node, store.history), *sinks):
            orchestrator.add_sink(sink)
        return orchestrator

    def _keep_house(self) -> Housekeeping | None:
        if self._journal is None:
            return None
        keep_jobs = self.parameters.journal_keep_jobs
        state, journal, writer = self.orchestrator.state, self._journal, self._writer
        return Housekeeping(state, journal, keep_jobs, writer, self._bookkeeping)

    def _read_orders(self) -> OrderReader:
        parameters, state = self.parameters, self.orchestrator.state
        process = order_process(state.cell, parameters.trees, any_path=parameters.script_paths)
        return OrderReader(state, process, partial(soon, self.executor))

    def _generate(self, parts: Parts) -> Generating:
        cell = self.orchestrator.state.cell
        return parts.make_generating(cell, self.parameters.recipes, partial(soon, self.executor))

    def _take_requests(self, types: InstalledActionTypes, store: EventStore) -> None:
        """Offer the services and the action."""
        handler = RequestHandler(
            self.orchestrator,
            types,
            self._orders,
            self._senders.why_no_panel,
            self._reasons,
            self._stops,
        )
        later = partial(soon, self.executor)
        self.orchestrator.add_sink(QueueAnew(handler, self.orchestrator.state, later))
        senders, state = self._senders, self.orchestrator.state
        Services(self.node, handler, senders, state)
        serve_lists(self.node, self._overview, state)
        EventsService(self.node, self.orchestrator, store, self._readings)
        StateService(self.node, self.orchestrator, self._durations)
        run_job = RunJobServer(
            self.node, self.orchestrator, self._overview, self._orders, self._expected, senders
        )
        self.orchestrator.add_sink(run_job)

    def _look_ahead(self, parts: Parts, pulse: Pulse, store: EventStore) -> ExpectedEnds:
        state = self.orchestrator.state
        self._durations.publish(last_events(store, state.seq))
        wanted = self.parameters.expected_end
        foresight = parts.make_foresight(state.cell) if wanted else None
        return ExpectedEnds(self.node, self.orchestrator, self._durations, foresight, pulse)

    def _show(self, pulse: Pulse, types: InstalledActionTypes) -> StatusTopic:
        DescriptionTopic(self.node, self.orchestrator.state.cell, types)
        engine, uptime = self.orchestrator, self._senders.uptime
        status = StatusTopic(self.node, engine, self._overview, self._expected, pulse, uptime)
        self.orchestrator.add_sink(status)
        Diagnostics(
            self.node, self.orchestrator, self._overview, self.heart, pulse, self._standbys
        )
        return status

    def _beat(self, settle: Callable[[], bool]) -> bool:
        """Settle, and do what goes with it; tell whether the next beat is to come soon."""
        happened = settle()
        if self._leading is not None:
            self._leading.look()
        is_inspected = self.parameters.inspection != BUILTIN  # the library looks on at settles
        if self._housekeeping is None:
            return is_inspected
        if self._is_durable:
            self._housekeeping.turn(quiet=not happened)
        return is_inspected or self._housekeeping.wants_turns

    @property
    def _is_durable(self) -> bool:
        """Tell whether the journal holds all of the state, and takes more."""
        return not self.orchestrator.broken and not self.orchestrator.awaits_disk

    def _linger(self, is_hurried: Callable[[], bool]) -> None:
        """Stay a moment: what a client has not taken when its publisher leaves, DDS drops."""
        until = time.monotonic() + LAST_WORDS_S
        while time.monotonic() < until and not is_hurried():
            self._spin_once(0.1)

    def _without_end(self) -> Iterator[str]:
        """Yield the tasks whose goals may go on; those in doubt count as ended."""
        state, breakdown = self.orchestrator.state, self.orchestrator.breakdown
        if breakdown is not None:
            yield from breakdown.in_flight
            return
        for key in state.reserved.values():
            if state.tasks[key].reason in (None, Reason.IN_DOUBT):
                yield f'{key} (goal {state.tasks[key].goal})'

    def _spin_once(self, timeout_s: float | None = None) -> None:
        try:
            spin_once(self.executor, timeout_s)
        except ExternalShutdownException:
            raise
        except Exception as error:  # noqa: BLE001 - an exception in a callback ends no cell
            self._log.error(f'a callback failed: {error!r}')


def run_node(
    defaults: NodeParameters,
    parts: Parts,
    stop: StopSignals,
    on_ready: Callable[[str], None],
    *,
    namespace: str = '',
    ros_args: Sequence[str] = (),
) -> list[str]:
    """Run the tree node until a stop signal.

    :param defaults: parameter values unless ROS is told otherwise
    :return: the tasks whose goals had not ended when it left, in words
    :raises OrchestratorError: it cannot start; says why
    """
    give_back()
    try:
        # rclpy's own handlers would end the context before goals are cancelled.
        rclpy.init(args=list(ros_args), signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        raise BadRosArguments(ros_says(error, os.environ)) from error
    try:
        try:
            cell = _build(namespace, defaults, parts, stop, on_ready)
        except NeverLed:
            return []
        # A task makes a waiting executor return; its own wake() would not.
        stop.notify(lambda: cell.executor.create_task(_nothing))
        collect_rarely()
        on_ready(cell.ready_line)
        try:
            cell.serve(stop)
            return cell.finish(stop)
        finally:
            stop.notify(_nothing)
            cell.close()
    finally:
        with leaving():
            rclpy.try_shutdown()


def _cell_file(parameters: NodeParameters) -> Path:
    here = Path(CELL_FILE)
    if parameters.cell is None and not here.exists():
        raise NoCell(
            f'expected a cell file; there is no {CELL_FILE} in {Path.cwd()}; '
            'name it: --cell CELL, or the parameter cell'
        )
    return parameters.cell or here


def _open_journal(parameters: NodeParameters, parts: Parts) -> Journal | None:
    if parameters.journal is None:
        return None
    return parts.open_journal(parameters.journal, parameters.journal_synchronous)


def _build(
    namespace: str,
    defaults: NodeParameters,
    parts: Parts,
    stop: StopSignals,
    say: Callable[[str], None],
) -> TreeNode:
    try:
        with prompt_answers(os.environ):
            node = Node(NODE_NAME, namespace=namespace)
        quieten(node)
        return TreeNode(node, defaults, parts, stop, say)
    except (NameValidationException, ParameterException) as error:
        raise BadRosArguments(f'ROS refuses a name or a parameter: {error}') from error


def _nothing() -> None:
    """Do nothing: waking the executor is all."""
