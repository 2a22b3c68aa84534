"""The part in PackML's types: Admin, Status, and the nested state machines with their commands."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import partial

import asyncua
from asyncua import ua

from bt_orchestrator.extensions.opcua.mes.packml import (
    CLEAR_AS_SHOWN,
    COMMANDS,
    MODE_NUMBERS,
    PRODUCE,
    PRODUCE_AS_SHOWN,
    Machine,
    command_fault,
    transitions_between,
)
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.calls import Argument, reason_of
from bt_orchestrator.extensions.opcua.server.nodesets import PACK_ML
from bt_orchestrator.extensions.opcua.server.notices import Told, id_of
from bt_orchestrator.extensions.opcua.server.packml_values import METHOD_MEANINGS, Shown, meanings
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.events import CellStateChanged, Event
from bt_orchestrator.model.packml import Cause, PackmlState, UnitMode
from bt_orchestrator.model.requests import CELL, UNIT_MODES, Request
from bt_orchestrator.model.status import CellStatus

log = logging.getLogger(__name__)

TOP = 'PackML'

_TYPES = {Machine.BASE: 3, Machine.MACHINE: 2, Machine.EXECUTE: 1}
_TYPE_OF_ALL = 6
"""Numbers of the types in the nodeset."""

_SET_MODE = 'SetUnitMode'

_NOT_OURS = ('SetMachSpeed', 'SetProduct', 'SetParameter')
"""Mandatory methods of the nodeset for what the cell does not have."""

_OPTIONALS = (
    'PackMLVersion',
    'Admin/ProdDefectiveCount',
    'Admin/ProdProcessedCount',
    'Admin/StateCumulativeTime',
    'Admin/StateCurrentTime',
    'Admin/StopReason',
    'Status/StateChangeInProcess',
    *(f'{machine.value}/CurrentState/Number' for machine in Machine),
    *(f'{machine.value}/LastTransition' for machine in Machine),
    *(f'{machine.value}/LastTransition/TransitionTime' for machine in Machine),
    *(f'{machine.value}/{name}' for machine, names in METHOD_MEANINGS.items() for name in names),
)


class PackML:
    """Implements `part.Part`."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._refused = 0

    async def build(self, space: Space) -> None:
        """Make the instance, and what the nodeset has no place for."""
        self._space = space
        namespace = space.ns[PACK_ML.uri]
        type_id = ua.NodeId(_TYPE_OF_ALL, namespace)
        await space.instance(space.cell, type_id, TOP, TOP, optionals=_OPTIONALS)
        self._names = {
            machine: await _children(space.server.get_node(ua.NodeId(number, namespace)))
            for machine, number in _TYPES.items()
        }
        self._shown = Shown(space, self._names)
        await self._shown.build()
        for machine, names in METHOD_MEANINGS.items():
            for name in names:
                call = partial(self._command, COMMANDS[name], name)
                await space.link(space.node(f'{TOP}/{machine.value}/{name}'), call)
                # A client may also name the method of the type, as generic ones do.
                await space.link(space.server.get_node(self._names[machine][name]), call)
        for name in _NOT_OURS:
            await space.link(space.node(f'{TOP}/{name}'), _not_supported)
        await space.link(space.node(f'{TOP}/{_SET_MODE}'), self._set_mode)
        await self._make_as_shown(
            CLEAR_AS_SHOWN,
            CELL[Cause.CLEAR],
            'says that the belt of an aborted cell is as PackML/Belt shows it; the cell is '
            'Stopped then',
        )
        await self._make_as_shown(
            PRODUCE_AS_SHOWN,
            UNIT_MODES[UnitMode.PRODUCTION],
            'ends manual mode, and says that the belt is as PackML/Belt shows it',
        )
        for path, meaning in meanings(TOP):
            await space.described(space.node(path), meaning)
        for path in (TOP, *(f'{TOP}/{machine.value}' for machine in Machine)):
            await space.node(path).set_event_notifier([ua.EventNotifier.SubscribeToEvents])

    async def _make_as_shown(self, name: str, request: Request, meaning: str) -> None:
        text = ua.VariantType.String
        await self._space.method(
            f'{TOP}/{name}',
            partial(self._as_shown, name, request),
            [
                Argument('Belt', text, 'PackML/Belt, as somebody compared it'),
                Argument('Reason', text, 'for the record'),
            ],
            [],
            meaning,
        )

    # --- what is told -----------------------------------------------------------------------

    def show(self, status: CellStatus) -> None:
        """Show a new status."""
        self._shown.show(status)

    def hear(self, event: Event) -> None:
        """Tell of transitions."""
        self._shown.hear(event)
        if isinstance(event, CellStateChanged):
            self._tell_transitions(event)

    def begin(self, history: str) -> None:  # noqa: ARG002 - as Part says
        """Count anew."""
        self._shown.begin()

    def _tell_transitions(self, event: CellStateChanged) -> None:
        before, after = PackmlState(event.previous), PackmlState(event.state)
        for transition in transitions_between(before, after):
            names = self._names[transition.machine]
            self._shown.put_transition(transition, event.time)
            node = self._space.id(f'{TOP}/{transition.machine.value}')
            why = ': '.join(filter(None, (event.cause, event.reason)))
            notice = Told(
                type_id=ua.NodeId(ua.ObjectIds.TransitionEventType),
                id=id_of(self._bridge.history, event.seq, transition.machine.value),
                source=node,
                source_name=transition.machine.value.rpartition('/')[2],
                time=event.time,
                message=f'{event.previous} to {event.state}{f" ({why})" if why else ""}',
                fields={
                    **_named('Transition', transition.name, names[transition.name]),
                    **_named('FromState', transition.before, names[transition.before]),
                    **_named('ToState', transition.after, names[transition.after]),
                },
            )
            self._space.notices.tell(notice, node, self._space.id(TOP))

    # --- commands ---------------------------------------------------------------------------

    async def _command(
        self, request: Request, name: str, parameters: Sequence[object] | None = None
    ) -> Sequence[ua.Variant]:
        """Carry out a command of the nodeset; only Start has an argument, which must be empty."""
        if parameters:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNotSupported)
        fault = command_fault(name, self._bridge.status.state)
        if fault is not None:
            raise await self._refusal(request, fault)
        return await self._ask(request, {}, reason_of('', name))

    async def _set_mode(self, mode: int) -> Sequence[ua.Variant]:
        """Enter manual mode; leaving it needs a statement of the belt."""
        is_manual = self._bridge.status.unit_mode is UnitMode.MANUAL
        request = UNIT_MODES[UnitMode.MANUAL]
        if mode == MODE_NUMBERS[UnitMode.MANUAL]:
            return await self._ask(request, {}, reason_of('', _SET_MODE))
        if mode != PRODUCE:
            raise ua.UaStatusCodeError(ua.StatusCodes.BadNotSupported)
        if is_manual:
            words = f'somebody has to look at the belt first: {PRODUCE_AS_SHOWN} ends manual mode'
            raise await self._refusal(UNIT_MODES[UnitMode.PRODUCTION], words)
        return []

    async def _as_shown(
        self, name: str, request: Request, belt: str, reason: str
    ) -> Sequence[ua.Variant]:
        seq, _, _ = belt.partition(':')
        if not seq.isascii() or not seq.isdecimal():
            raise ua.UaStatusCodeError(ua.StatusCodes.BadInvalidArgument)
        return await self._ask(request, {'as_shown': int(seq)}, reason_of(reason, name))

    async def _ask(
        self, request: Request, arguments: Mapping[str, object], reason: str
    ) -> Sequence[ua.Variant]:
        outcome = await self._bridge.calls.ask(request, arguments, reason)
        if not outcome.accepted:
            raise await self._refusal(request, outcome.message)
        return []

    async def _refusal(self, request: Request, message: str) -> ua.UaStatusCodeError:
        self._tell_refusal(request, message)
        await self._space.values.write()  # for a client that reads why at once
        return ua.UaStatusCodeError(ua.StatusCodes.BadInvalidState)

    def _tell_refusal(self, request: Request, message: str) -> None:
        """Say why: PackML's methods have no output for it."""
        self._refused += 1
        status = self._bridge.status
        self._shown.put_refusal(message, status.stamp)
        notice = Told(
            type_id=ua.NodeId(ua.ObjectIds.BaseEventType),
            id=id_of(status.history, status.stamp, 'refused', self._refused),
            source=self._space.id(TOP),
            source_name=TOP,
            time=status.stamp,
            message=f'{request.word} refused: {message}',
            severity=300,
        )
        self._space.notices.tell(notice, notice.source)


async def _not_supported(*_: object) -> Sequence[ua.Variant]:
    """Answer for what the cell does not have."""
    raise ua.UaStatusCodeError(ua.StatusCodes.BadNotSupported)


def _named(name: str, text: str, id_: ua.NodeId) -> Mapping[str, ua.Variant]:
    return {
        name: ua.Variant(ua.LocalizedText(text), ua.VariantType.LocalizedText),
        f'{name}/Id': ua.Variant(id_, ua.VariantType.NodeId),
    }


async def _children(node: asyncua.Node) -> Mapping[str, ua.NodeId]:
    """Return states, transitions and methods of a machine's type, by name."""
    return {
        description.BrowseName.Name: description.NodeId
        for description in await node.get_children_descriptions()
    }
