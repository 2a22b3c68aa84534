"""The part of ISA-95 Job Control: a receiver of job orders and a provider of job responses."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Mapping, Sequence

from asyncua import ua

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.opcua.mes.followed_jobs import News
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.job_control.job_orders import Jobs
from bt_orchestrator.extensions.opcua.server.job_control.lists import MOST, JobLists, chosen
from bt_orchestrator.extensions.opcua.server.job_control.receiver import (
    Receiver,
    Shown,
    answer,
    one,
)
from bt_orchestrator.extensions.opcua.server.job_control.records import Records
from bt_orchestrator.extensions.opcua.server.job_control.status_events import StatusEvents
from bt_orchestrator.extensions.opcua.server.job_control.structures import (
    RESPONSE,
    Structures,
    listed,
    none_of,
    states_from,
    work_master,
)
from bt_orchestrator.extensions.opcua.server.nodesets import JOB_CONTROL
from bt_orchestrator.extensions.opcua.server.space import Call, Space
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_control import METHODS
from bt_orchestrator.model.script import Parameter as Declared
from bt_orchestrator.model.status import CellStatus, ListedJob
from bt_orchestrator.script.orders.by_recipe import DeclaredVersion
from bt_orchestrator.view.report.isa95.codes import MACHINES, ReturnStatus, are_known, has_all
from bt_orchestrator.view.report.isa95.job_response import response_of
from bt_orchestrator.view.report.isa95.parts import Parameter, Text, WorkMaster

RECEIVER, RESULTS = 'JobOrderControl', 'JobOrderResults'

_RECEIVER_TYPE, _METHODS_TYPE, _RESULTS_TYPE = 1008, 1002, 1003
"""ISA95JobOrderReceiverSubStatesType, its supertype that has the methods, and
ISA95JobResponseProviderObjectType."""

_STATES = tuple(
    f'{machine}/CurrentState{id_}'
    for machine in (RECEIVER, *(f'{RECEIVER}/{name}' for name in MACHINES))
    for id_ in ('', '/Id')
)
"""Of the receiver there is no state, only of each of its orders."""

_MEANINGS = {
    RECEIVER: 'takes job orders and changes them (OPC 10031-4)',
    f'{RECEIVER}/MaxDownloadableJobOrders': 'the most orders in JobOrderList; the queue of the '
    'cell may be longer',
    RESULTS: 'what became of job orders, and the events of their states (OPC 10031-4)',
    f'{RESULTS}/RequestJobResponseByJobOrderID': 'the response about one job order',
    f'{RESULTS}/RequestJobResponseByJobOrderState': 'the responses about the listed job orders '
    'in a state',
    f'{RESULTS}/JobOrderResponseList': 'the responses about the orders in JobOrderList that have '
    'started',
}
"""Where the nodeset says nothing of a node, or nothing that a reader could use."""

_EMPTY = ('PersonnelID', 'PhysicalAssetID', 'MaterialClassID', 'MaterialDefinitionID')
"""Their names in an order are not checked, and no list of them is known."""


class JobControl:
    """Implements `part.Part`."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._jobs = Jobs(bridge, self._tell, self._show_again)
        self._masters = WorkMasters(bridge)
        self._looking: asyncio.Task[None] | None = None

    async def build(self, space: Space) -> None:
        """Make both instances, and learn how the jobs stand."""
        self._space = space
        self._index = space.ns[JOB_CONTROL.uri]
        structures = Structures(self._index)
        self._lists = JobLists(structures)
        await self._make_instances(space)
        receiver, results = space.id(RECEIVER), space.id(RESULTS)
        self._events = StatusEvents(space, structures, results, receiver)
        await self._events.build(self._index)
        self._shown = Shown(space.values)
        orders = Receiver(self._bridge, self._jobs, self._events, self._shown)
        answers = Results(self._jobs, structures, self._listed)
        await self._link(RECEIVER, _METHODS_TYPE, orders.calls())
        await self._link(RESULTS, _RESULTS_TYPE, answers.calls())
        await Records(self._bridge).build(space, RESULTS)
        await self._bridge.orderable.look()
        await self._jobs.begin()
        self._put_constants()

    async def _make_instances(self, space: Space) -> None:
        methods = [method.name for method in METHODS]
        for path, type_, optionals in (
            (RECEIVER, _RECEIVER_TYPE, (*methods, *MACHINES)),
            (RESULTS, _RESULTS_TYPE, ('JobOrderResponseList',)),
        ):
            node = await space.instance(
                space.cell, ua.NodeId(type_, self._index), path, path, optionals=optionals
            )
            await node.set_event_notifier([ua.EventNotifier.SubscribeToEvents])
        meanings = {f'{RECEIVER}/{method.name}': method.meaning for method in METHODS}
        for path, meaning in {**_MEANINGS, **meanings}.items():
            await space.described(space.node(path), meaning)

    async def _link(self, path: str, type_: int, calls: Mapping[str, Call]) -> None:
        """Have methods carried out, also where a client names the method of the type."""
        declared = self._space.server.get_node(ua.NodeId(type_, self._index))
        of_type = {
            description.BrowseName.Name: description
            for description in await declared.get_children_descriptions()
        }
        for name, call in calls.items():
            await self._space.link(self._space.node(f'{path}/{name}'), call)
            await self._space.link(self._space.server.get_node(of_type[name].NodeId), call)

    def _put_constants(self) -> None:
        description = self._bridge.description
        names = [description.conveyor, *(component.name for component in description.components)]
        stamp = self._bridge.status.stamp
        text = ua.VariantType.String
        lists = {'EquipmentID': sorted(set(names)), **{name: [] for name in _EMPTY}}
        for name, ids in lists.items():
            node = self._space.node(f'{RECEIVER}/{name}')
            self._space.values.put(node, ua.Variant(ids, text, is_array=True), stamp, is_own=True)
        for path in _STATES:
            inactive = ua.StatusCodes.BadStateNotActive
            node = self._space.node(path)
            self._space.values.put(node, ua.Variant(), stamp, is_own=True, code=inactive)
        most = self._space.node(f'{RECEIVER}/MaxDownloadableJobOrders')
        self._space.values.put(most, ua.Variant(MOST, ua.VariantType.UInt16), stamp, is_own=True)

    # --- what is heard ----------------------------------------------------------------------

    def show(self, status: CellStatus) -> None:
        """Show the jobs of a status."""
        self._jobs.show(status)
        self._show(status)
        if self._bridge.orderable.is_due and (self._looking is None or self._looking.done()):
            self._looking = asyncio.ensure_future(self._look())

    def hear(self, event: Event) -> None:
        """Tell of changes of state; a status may have come before its events."""
        self._jobs.hear(event)
        if event.seq == self._bridge.status.seq:
            self._show(self._bridge.status)

    def begin(self, history: str) -> None:
        """Forget the jobs."""
        del history
        self._jobs.forget()

    def _tell(self, news: News) -> None:
        self._events.tell(news, self._bridge.history)

    def _show_again(self) -> None:
        self._show(self._bridge.status)

    def _show(self, status: CellStatus) -> None:
        self._put(status)
        self._shown.reached(min(status.seq, self._jobs.followed.seq))

    def _put(self, status: CellStatus) -> None:
        jobs = chosen(self._jobs.listed(status).values())
        values, stamp = self._space.values, status.stamp
        interrupted = status.stop_message if status.stop_reason is not None else ''
        values.put(self._space.node(f'{RECEIVER}/JobOrderList'), self._lists.orders(jobs), stamp)
        responses = self._lists.responses(jobs, interrupted)
        values.put(self._space.node(f'{RESULTS}/JobOrderResponseList'), responses, stamp)
        values.put(self._space.node(f'{RECEIVER}/WorkMaster'), self._masters.value(), stamp)

    def _listed(self) -> list[ListedJob]:
        return list(self._jobs.listed(self._bridge.status).values())

    async def _look(self) -> None:
        await self._bridge.orderable.look()
        self._show_again()


# The job response provider: what became of a job, by its id or by its state.


class Results:
    """The two methods of ISA95JobResponseProviderObjectType."""

    def __init__(
        self, jobs: Jobs, structures: Structures, shown: Callable[[], Iterable[ListedJob]]
    ) -> None:
        """Prepare.

        :param shown: returns the jobs that the newest status lists
        """
        self._jobs = jobs
        self._structures = structures
        self._shown = shown

    def calls(self) -> Mapping[str, Call]:
        """Return what carries out each method, by its name."""
        return {
            'RequestJobResponseByJobOrderID': self._by_id,
            'RequestJobResponseByJobOrderState': self._by_state,
        }

    async def _by_id(self, name: str) -> ua.CallMethodResult:
        nothing = one(none_of(RESPONSE))
        if not name:
            return answer(ReturnStatus.MALFORMED, nothing)
        try:
            job = await self._jobs.ask(name)
        except NodeUnreachable as error:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNoCommunication) from error
        if job is None:
            return answer(ReturnStatus.UNKNOWN_ID, nothing)
        return answer(ReturnStatus.DONE, one(self._response(job)))

    async def _by_state(self, wanted: Sequence[object]) -> ua.CallMethodResult:
        if not wanted:
            return answer(ReturnStatus.MALFORMED, listed([]))
        states = states_from(wanted)
        if not are_known(states):
            return answer(ReturnStatus.WRONG_STATE, listed([]))
        responses = (response_of(job, self._jobs.followed.interrupted) for job in self._shown())
        matches = [response for response in responses if has_all(response.states, states)]
        return answer(ReturnStatus.DONE, listed(list(map(self._structures.response, matches))))

    def _response(self, job: ListedJob) -> object:
        return self._structures.response(response_of(job, self._jobs.followed.interrupted))


# The work masters: the scripts and recipes that an order can name, with their parameters.


class WorkMasters:
    """The value of `WorkMaster`; it is made anew when another one is known."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._value = listed([])
        self._made_from: object = None

    def value(self) -> ua.Variant:
        """Return them by name: those in the folders, and the scripts of jobs that are known."""
        files, scripts = self._bridge.orderable, self._bridge.known.scripts
        made_from = (files.looked_at, tuple(scripts))
        if made_from != self._made_from:
            heard = {
                script.name: _master(script.name, script.params.values())
                for script in scripts.values()
            }
            read = {
                name: _master(name, script.params.values())
                for name, script in files.scripts.items()
            }
            recipes = {name: _of_recipe(recipe.newest) for name, recipe in files.recipes.items()}
            masters = {**heard, **recipes, **read}
            self._made_from = made_from
            self._value = listed([work_master(masters[name]) for name in sorted(masters)])
        return self._value


def _of_recipe(recipe: DeclaredVersion) -> WorkMaster:
    return _master(recipe.name, recipe.params.values(), f'recipe, version {recipe.version}')


def _master(name: str, params: Iterable[Declared], about: str = '') -> WorkMaster:
    return WorkMaster(
        name,
        about,
        tuple(
            Parameter(
                param.name,
                param.default,
                (Text(f'{param.type}, {"required" if param.required else "optional"}', 'en'),),
            )
            for param in params
        ),
    )
