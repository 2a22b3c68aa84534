"""Services with requests: any by its name, and a door of its own for those of earlier versions."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, overload

from bt_orchestrator_interfaces import srv
from rclpy.node import Node

from bt_orchestrator.base.diagnosis.ros_environment import is_local
from bt_orchestrator.base.errors import CommandRefused, NotRead, OrchestratorError
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.orders import size_of
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.limits import NAME, REQUEST_BYTES, cut
from bt_orchestrator.model.requests import of_name
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.texts import readable
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ros.clock import MachineUptime
from bt_orchestrator.ros.node_parameters import AUTO, REQUIRED, NodeParameters
from bt_orchestrator.ros.services.patient_service import serve
from bt_orchestrator.ros.types.order_messages import asked_change, asked_order
from bt_orchestrator.ros.types.status_messages import order_answer_message
from bt_orchestrator.script.orders.desk import AskedOrder, WrittenOrder
from bt_orchestrator.script.users.file import KnownUsers, default_file
from bt_orchestrator.script.users.keys import Keys, Place, Signatures, demand_library, opened

_Read = Callable[[Any], tuple[str, Any]]
"""Returns the name of the request in a message, and its arguments."""


def _fields(name: str, message: Any) -> tuple[str, dict[str, Any]]:
    """Return a request with those fields of a message that it takes and that say something."""
    request = of_name(name)
    values = (
        {
            parameter.name: getattr(message, parameter.name, None)
            for parameter in request.parameters
        }
        if request
        else {}
    )
    return name, {name: value for name, value in values.items() if value}


def _command(message: Any) -> tuple[str, dict[str, Any]]:
    subject = 'component' if message.component else 'script' if message.script else 'cell'
    return _fields(f'{subject}.{message.command}', message)


def _answer(message: Any) -> tuple[str, dict[str, Any]]:
    given = {'hold': message.hold, 'results': message.results or None}
    return f'hold.{message.answer}', given


DOORS: tuple[tuple[Any, str, _Read], ...] = (
    (srv.MakeRequest, 'request', lambda message: (message.name, message.arguments)),
    (srv.AnswerHold, 'answer_hold', _answer),
    (srv.RemoveItem, 'remove_item', partial(_fields, 'item.remove_item')),
    (srv.Command, 'command', _command),
    (srv.QueueMove, 'queue/move', partial(_fields, 'job.move')),
    (srv.QueueCommand, 'queue/command', lambda it: _fields(f'job.{it.command}', it)),
    (
        srv.QueueStopAfter,
        'queue/stop_after',
        lambda it: _fields(f'cell.stop_after_{it.after}', it),
    ),
)
"""Services with one request, as the table of requests names it."""


class Services:
    """Requests become commands in the one inbox of the cell; nothing is decided here."""

    def __init__(
        self, node: Node, handler: RequestHandler, senders: Senders, state: CellState
    ) -> None:
        self._signatures = senders.signatures(node.get_fully_qualified_name(), state)
        self._handler = handler
        self._senders = senders
        self._state = state
        for kind, name, read in DOORS:
            serve(node, kind, name, partial(self._carry_out, read))
        serve(node, srv.SubmitOrder, 'submit_order', self._submit)
        serve(node, srv.QueueAdd, 'queue/add', self._add)
        serve(node, srv.QueueUpdate, 'queue/update', self._update)
        serve(node, srv.SignedRequest, 'signed_request', self._signed)

    async def _carry_out(self, read: _Read, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        self._tell(response, await self._handler.carry_out_named(*read(request), by))

    async def _signed(self, request: Any, response: Any) -> None:
        try:
            sealed = opened(request.request)
        except CommandRefused as why:
            nobody = By('', 'service', '', Role.VIEW)
            self._tell(response, await self._handler.refuse_named('', {}, nobody, str(why)))
            return
        try:
            signature = bytes(request.signature)
            by = self._signatures.sender(sealed, request.request, request.key, signature)
        except OrchestratorError as why:
            by = self._senders.claimed(sealed)
            answer = await self._handler.refuse_named(sealed.name, {}, by, str(why))
        else:
            answer = await self._handler.carry_out_named(sealed.name, sealed.arguments, by)
        self._tell(response, answer)

    async def _submit(self, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        self._tell(response, await self._handler.add([asked_order(request)], by))

    async def _add(self, request: Any, response: Any) -> None:
        orders, by = AskedOrders(request.orders), self._senders.by(request)
        position = request.position or None
        answer = await self._handler.add(orders, by, position, held=request.held)
        self._tell(response, answer)

    async def _update(self, request: Any, response: Any) -> None:
        wish, by = asked_change(request), self._senders.by(request)
        self._tell(response, await self._handler.update(request.job, wish, by))

    def _tell(self, response: Any, answer: Answer) -> None:
        """Put an answer into a response, as far as that has fields for it."""
        fields: dict[str, object] = {
            'accepted': answer.accepted,
            'message': answer.message,
            'answers': list(map(order_answer_message, answer.orders)),
            'state': self._state.packml.value,
        }
        for of_order in answer.orders:
            fields |= {'job': of_order.job, 'findings': of_order.findings}
        for name in fields.keys() & set(response.get_fields_and_field_types()):
            setattr(response, name, fields[name])


# Messages with work orders as what is to be read.


class AskedOrders(Sequence[AskedOrder]):
    """Orders of a request, each made when it is asked for: too many are refused unread."""

    def __init__(self, messages: Sequence[Any]) -> None:
        """Show them.

        :param messages: bt_orchestrator_interfaces/msg/WorkOrder
        """
        self._messages = messages

    def __len__(self) -> int:
        return len(self._messages)

    @overload
    def __getitem__(self, at: int) -> AskedOrder: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[AskedOrder]: ...
    def __getitem__(self, at: int | slice) -> AskedOrder | Sequence[AskedOrder]:
        if isinstance(at, slice):
            return AskedOrders(self._messages[at])
        return asked_order(self._messages[at])


def written_order(text: str) -> WrittenOrder:
    """Return an order that came as the text of a file.

    :raises NotRead: it is too large
    """
    if size_of(text) > REQUEST_BYTES:
        raise NotRead(
            f'the text has {size_of(text)} bytes, and a request may have {REQUEST_BYTES}; nothing '
            'was queued; is this a work order?'
        )
    return WrittenOrder(text)


# Sender and role of a request over ROS; ROS does not authenticate senders (docs/security.md).

_ROLES = {role.value: role for role in Role}
_DOORS = {known.value: known for known in Known if known.is_door}


class Senders:
    """Determines the role of each sender."""

    def __init__(
        self, parameters: NodeParameters, environment: Mapping[str, str], middleware: str
    ) -> None:
        """Set which roles are trusted, for as long as the node runs.

        :param environment: variables that say how far ROS reaches
        :param middleware: name of the RMW implementation
        :raises KeyUnusable: signatures are required, and cannot be checked
        """
        self.is_local = is_local(environment, middleware)
        self._known_users: KnownUsers | None = None
        self.unauthenticated = _unauthenticated(parameters, is_local=self.is_local)
        self.signed_commands = parameters.signed_commands
        self._parameters, self._environment = parameters, environment
        is_signing = self.signed_commands == REQUIRED
        if is_signing:
            demand_library()
        self.trusts_doors = parameters.trust_local_doors and self.is_local and not is_signing
        self._machine = MachineUptime()
        self._since = uuid.uuid4().hex

    def by(self, request: Any, otherwise: str = 'service') -> By:
        """Return the sender, the origin, the reason and the role.

        :param otherwise: where from, if the request does not say it
        """
        origin = request.origin or otherwise
        sender = (request.who, origin, request.reason)
        door = _DOORS.get(request.known)
        if self.trusts_doors and door is not None:
            # A role that this node does not know may do nothing.
            return By(*sender, _ROLES.get(request.role, Role.VIEW), door)
        return By(*sender, self.unauthenticated, Known.ROS, _claims(request))

    def claimed(self, request: Any) -> By:
        """Return the sender of a request whose signature does not count."""
        sender = (request.who, request.origin or 'service', request.reason)
        return By(*sender, Role.VIEW, Known.ROS, _claims(request))

    def uptime(self) -> Uptime:
        """Return the uptime of this computer; where it cannot be known, of this process."""
        return self._machine.now() or Uptime(self._since, round(time.monotonic(), 3))

    def signatures(self, node: str, state: CellState) -> Signatures:
        """Return what checks signed requests to a node."""

        def here() -> Place:
            return Place(node, state.history, self.uptime())

        def keys() -> Keys:
            return self._users().keys()

        return Signatures(keys, lambda: self._users().panels().keys, here, state.signatures)

    def _users(self) -> KnownUsers:
        """Return the users of now.

        :raises NoHome: it is not known where their file is
        """
        if self._known_users is None:
            path = self._parameters.users or default_file(self._environment)
            self._known_users = KnownUsers(path)
        return self._known_users

    def why_no_panel(self) -> str:
        """Say why no request can come from a panel of the line (7.8); empty: one can.

        A panel may have been named a moment ago.
        """
        try:
            users = self._users()
            panels, keys = users.panels(), users.keys()
        except OrchestratorError as error:
            return str(error)
        if not panels:
            return sentence('no_panel_named', file=users.path)
        if panels.keys or self.trusts_doors or any(key.door for key in keys.values()):
            return ''
        return sentence('no_door_believed')

    def of_cancel(self, goal_by: By) -> By:
        """Return the sender of a cancel request, which may be any client."""
        who, origin = goal_by.who, goal_by.origin
        return By(who, origin, 'the goal was cancelled', self.unauthenticated, Known.ROS)


def _unauthenticated(parameters: NodeParameters, *, is_local: bool) -> Role:
    if parameters.signed_commands == REQUIRED:
        return Role.VIEW
    if parameters.unauthenticated_role == AUTO:
        return Role.ENGINEER if is_local else Role.VIEW
    return Role(parameters.unauthenticated_role)


def _claims(request: Any) -> str:
    if not request.role:
        return ''
    how = f' ({request.known})' if request.known else ''
    return readable(cut(f'{request.role}{how}', NAME))
