"""The address space of one cell: its nodes have paths as ids, in a namespace of their own."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence

import asyncua
from asyncua import ua

from bt_orchestrator.extensions.opcua.server.calls import (
    Argument,
    declared_at,
    with_status,
    wrong,
)
from bt_orchestrator.extensions.opcua.server.instances import Instances
from bt_orchestrator.extensions.opcua.server.notices import Notices
from bt_orchestrator.extensions.opcua.server.values import Values

log = logging.getLogger(__name__)

Outputs = Sequence[ua.Variant]

Call = Callable[..., Awaitable['Outputs | ua.CallMethodResult']]
"""Carries out a method: takes the values of its arguments, returns those of its outputs. A
`ua.UaStatusCodeError` that it raises becomes the status of the call."""

NAMESPACE = 'urn:bt_orchestrator:cell:'
"""Begin of the namespace's URI; the name of the cell follows."""

_Handler = Callable[..., Awaitable['ua.CallMethodResult']]


class Space:
    """Makes nodes. The parent of a node is that of its path; above the first name is the cell."""

    def __init__(
        self,
        server: asyncua.Server,
        idx: int,
        cell: asyncua.Node,
        ns: Mapping[str, int],
    ) -> None:
        self.server = server
        self.idx = idx
        """Index of the namespace of the cell."""
        self.cell = cell
        """Objects/<cell>."""
        self.ns = ns
        """Indexes of the namespaces of the nodesets, by URI."""
        self.values = Values(server)
        self.notices = Notices(server, cell.nodeid)
        self._instances = Instances(server, idx)

    @classmethod
    async def of(cls, server: asyncua.Server, cell: str, ns: Mapping[str, int]) -> Space:
        """Begin the space of a cell."""
        idx = await server.register_namespace(NAMESPACE + cell)
        top = await server.get_objects_node().add_object(
            ua.NodeId(cell, idx), ua.QualifiedName(cell, idx)
        )
        await top.set_event_notifier([ua.EventNotifier.SubscribeToEvents])
        return cls(server, idx, top, ns)

    # --- ids --------------------------------------------------------------------------------

    def id(self, path: str) -> ua.NodeId:
        """Return the id of a node, for instance of `Simple/CurrentJob/ID`."""
        return ua.NodeId(path, self.idx)

    def node(self, path: str) -> asyncua.Node:
        """Return a node of the cell."""
        return self.server.get_node(self.id(path))

    def _parent(self, path: str) -> asyncua.Node:
        above, _, _ = path.rpartition('/')
        return self.node(above) if above else self.cell

    def _name(self, path: str) -> ua.QualifiedName:
        return ua.QualifiedName(path.rpartition('/')[2], self.idx)

    # --- nodes ------------------------------------------------------------------------------

    async def folder(self, path: str, meaning: str) -> asyncua.Node:
        """Make a folder."""
        node = await self._parent(path).add_folder(self.id(path), self._name(path))
        return await self.described(node, meaning)

    async def object(self, path: str, meaning: str) -> asyncua.Node:
        """Make an object."""
        node = await self._parent(path).add_object(self.id(path), self._name(path))
        return await self.described(node, meaning)

    async def variable(
        self, path: str, type_: ua.VariantType, meaning: str, *, is_list: bool = False
    ) -> asyncua.Node:
        """Make a variable that clients can read."""
        value: object = [] if is_list else ua.get_default_value(type_)
        variant = ua.Variant(value, type_, is_array=is_list)
        node = await self._parent(path).add_variable(
            self.id(path), self._name(path), variant, datatype=ua.NodeId(type_.value)
        )
        await node.write_value_rank(ua.ValueRank.OneDimension if is_list else ua.ValueRank.Scalar)
        return await self.described(node, meaning)

    async def method(
        self,
        path: str,
        call: Call,
        inputs: Sequence[Argument],
        outputs: Sequence[Argument],
        meaning: str,
    ) -> asyncua.Node:
        """Make a method; its arguments are checked before `call`."""
        node = await self._parent(path).add_method(
            self.id(path),
            self._name(path),
            answering(call, inputs),
            [argument.declared for argument in inputs],
            [output.declared for output in outputs],
        )
        return await self.described(node, meaning)

    async def event_type(
        self, name: str, base: ua.NodeId, fields: Sequence[Argument], meaning: str
    ) -> asyncua.Node:
        """Make a type of events with fields of its own."""
        made = await self.server.get_node(base).add_object_type(
            self.id(name), ua.QualifiedName(name, self.idx)
        )
        for field in fields:
            value = [] if field.is_list else ua.get_default_value(field.type)
            node = await made.add_property(
                self.id(f'{name}/{field.name}'),
                ua.QualifiedName(field.name, self.idx),
                ua.Variant(value, field.type, is_array=field.is_list),
            )
            await node.set_modelling_rule(True)
            await self.described(node, field.meaning)
        return await self.described(made, meaning)

    async def instance(
        self,
        parent: asyncua.Node,
        type_id: ua.NodeId,
        name: str,
        path: str,
        *,
        optionals: Collection[str] = (),
    ) -> asyncua.Node:
        """Make a whole instance of a type of a nodeset.

        :param optionals: paths below it of optional members that it has, or `instances.ALL`
        """
        browse_name = ua.QualifiedName(name, self.idx)
        return await self._instances.make(parent, type_id, browse_name, path, optionals)

    async def link(self, node: asyncua.Node, call: Call) -> None:
        """Have a method of a nodeset carried out; its arguments are checked before `call`."""
        inputs = await declared_at(self.server, node)
        self.server.link_method(node, answering(call, inputs))

    async def described(self, node: asyncua.Node, meaning: str) -> asyncua.Node:
        """Have a node say what it is."""
        text = ua.Variant(ua.LocalizedText(meaning), ua.VariantType.LocalizedText)
        await node.write_attribute(ua.AttributeIds.Description, ua.DataValue(text))
        return node


def answering(call: Call, inputs: Sequence[Argument]) -> _Handler:
    """Return what asyncua calls for a method: errors become statuses, and nothing else is lost."""

    async def answer(parent: ua.NodeId, *given: ua.Variant) -> ua.CallMethodResult:
        del parent
        misfit = wrong(inputs, given)
        if misfit is not None:
            return misfit
        try:
            outputs = await call(
                *(argument.value_of(value) for argument, value in zip(inputs, given, strict=False))
            )
        except ua.UaStatusCodeError as error:
            return with_status(error.code)
        if isinstance(outputs, ua.CallMethodResult):
            return outputs
        result = with_status(ua.StatusCodes.Good)
        result.OutputArguments = list(outputs)
        return result

    return answer
