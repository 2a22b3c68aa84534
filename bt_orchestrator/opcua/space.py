"""The address space of one cell: its nodes have paths as ids, in a namespace of their own."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import asyncua
from asyncua import ua

from bt_orchestrator.opcua.instances import Instances
from bt_orchestrator.opcua.notices import Notices
from bt_orchestrator.opcua.values import Values

log = logging.getLogger(__name__)

Outputs = Sequence[ua.Variant]

Call = Callable[..., Awaitable['Outputs | ua.CallMethodResult']]
"""Carries out a method: takes the values of its arguments, returns those of its outputs. A
`ua.UaStatusCodeError` that it raises becomes the status of the call."""

NAMESPACE = 'urn:bt_orchestrator:cell:'
"""Begin of the namespace's URI; the name of the cell follows."""

_Handler = Callable[..., Awaitable['ua.CallMethodResult']]


@dataclass(frozen=True)
class Argument:
    """An argument of a method of ours, or an output."""

    name: str
    type: ua.VariantType
    meaning: str
    is_list: bool = False
    is_optional: bool = False
    """Of a method that had fewer arguments before; clients that know it so leave it out."""

    def accepts(self, given: ua.Variant) -> bool:
        """Tell whether a value is of its type; null is an empty text, or no list."""
        if given.VariantType is ua.VariantType.Null:
            return self.is_list or self.type is ua.VariantType.String
        if self.is_list and given.Value is None:
            return True
        return given.VariantType is self.type and given.is_array is self.is_list

    def value_of(self, given: ua.Variant) -> Any:
        """Return the value for the method; a text is never null."""
        if self.is_list:
            return [one or '' for one in given.Value or ()] if self._is_text else given.Value or []
        return given.Value or '' if self._is_text else given.Value

    @property
    def _is_text(self) -> bool:
        return self.type is ua.VariantType.String

    @property
    def declared(self) -> ua.Argument:
        """As clients read it."""
        declared = ua.Argument()
        declared.Name = self.name
        declared.DataType = ua.NodeId(self.type.value)
        declared.ValueRank = 1 if self.is_list else -1
        declared.ArrayDimensions = [0] if self.is_list else []
        declared.Description = ua.LocalizedText(self.meaning)
        return declared


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
            [one.declared for one in inputs],
            [one.declared for one in outputs],
        )
        return await self.described(node, meaning)

    async def event_type(
        self, name: str, base: ua.NodeId, fields: Sequence[Argument]
    ) -> asyncua.Node:
        """Make a type of events with fields of its own."""
        made = await self.server.get_node(base).add_object_type(
            self.id(name), ua.QualifiedName(name, self.idx)
        )
        for one in fields:
            value = [] if one.is_list else ua.get_default_value(one.type)
            node = await made.add_property(
                self.id(f'{name}/{one.name}'),
                ua.QualifiedName(one.name, self.idx),
                ua.Variant(value, one.type, is_array=one.is_list),
            )
            await node.set_modelling_rule(True)
            await self.described(node, one.meaning)
        return made

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

    def link(self, node: asyncua.Node, call: Call) -> None:
        """Have a method of a nodeset carried out; `call` gets what the client sent."""
        self.server.link_method(node, answering(call))

    async def described(self, node: asyncua.Node, meaning: str) -> asyncua.Node:
        """Have a node say what it is."""
        text = ua.Variant(ua.LocalizedText(meaning), ua.VariantType.LocalizedText)
        await node.write_attribute(ua.AttributeIds.Description, ua.DataValue(text))
        return node


def answering(call: Call, inputs: Sequence[Argument] | None = None) -> _Handler:
    """Return what asyncua calls for a method: errors become statuses, and nothing else is lost.

    :param inputs: what to check; None: `call` does it
    """

    async def answer(parent: ua.NodeId, *given: ua.Variant) -> ua.CallMethodResult:
        del parent
        if inputs is not None and (wrong := _wrong(inputs, given)) is not None:
            return wrong
        if inputs is None:
            values = [one.Value for one in given]
        else:
            values = [one.value_of(value) for one, value in zip(inputs, given, strict=False)]
        try:
            outputs = await call(*values)
        except ua.UaStatusCodeError as error:
            return _result(error.code)
        if isinstance(outputs, ua.CallMethodResult):
            return outputs
        result = _result(ua.StatusCodes.Good)
        result.OutputArguments = list(outputs)
        return result

    return answer


def _wrong(inputs: Sequence[Argument], given: Sequence[ua.Variant]) -> ua.CallMethodResult | None:
    """Return what is wrong with arguments, argument by argument; None: nothing."""
    if len(given) < sum(not one.is_optional for one in inputs):
        return _result(ua.StatusCodes.BadArgumentsMissing)
    if len(given) > len(inputs):
        return _result(ua.StatusCodes.BadTooManyArguments)
    codes = [
        ua.StatusCodes.Good if one.accepts(value) else ua.StatusCodes.BadTypeMismatch
        for one, value in zip(inputs, given, strict=False)
    ]
    if not any(codes):
        return None
    result = _result(ua.StatusCodes.BadInvalidArgument)
    result.InputArgumentResults = [ua.StatusCode(code) for code in codes]
    return result


def _result(code: int) -> ua.CallMethodResult:
    result = ua.CallMethodResult()
    result.StatusCode = ua.StatusCode(code)
    return result
