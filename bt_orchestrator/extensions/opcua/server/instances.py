"""Instances of the types of a nodeset, whole: members of nested objects, too."""

from __future__ import annotations

from collections.abc import AsyncIterator, Collection

import asyncua
from asyncua import ua

_MANDATORY = ua.NodeId(ua.ObjectIds.ModellingRule_Mandatory)
_OPTIONAL = ua.NodeId(ua.ObjectIds.ModellingRule_Optional)
_BITS = ua.AttributeIds

ALL = frozenset({'*'})
"""Every optional member."""

_COPIED = {
    ua.NodeClass.Object: (ua.ObjectAttributes, (_BITS.EventNotifier,)),
    ua.NodeClass.Variable: (
        ua.VariableAttributes,
        (_BITS.Value, _BITS.DataType, _BITS.ValueRank, _BITS.ArrayDimensions),
    ),
    ua.NodeClass.Method: (ua.MethodAttributes, ()),
}
"""Attributes that an instance takes from its declaration, besides its names."""


_MEANINGS = {
    'InputArguments': 'what a call takes',
    'OutputArguments': 'what a call returns',
    'CurrentState': 'state of this machine; BadStateNotActive while it has none',
    'LastTransition': 'last transition of this machine',
    'Id': 'its node in the nodeset of the standard',
    'Number': 'its number in the nodeset of the standard',
    'TransitionTime': 'when it was',
    'AvailableStates': 'the states that this machine can have here',
    'AvailableTransitions': 'the transitions that this machine can make here',
    'EURange': 'lowest and highest value; BadNotSupported if the cell knows none',
}
"""Members of whose meaning the nodesets say nothing, by browse name."""


class Instances:
    """Makes instances in one namespace, with paths as their ids."""

    def __init__(self, server: asyncua.Server, namespace: int) -> None:
        self._server = server
        self._namespace = namespace

    async def make(
        self,
        parent: asyncua.Node,
        type_id: ua.NodeId,
        name: ua.QualifiedName,
        path: str,
        optionals: Collection[str],
    ) -> asyncua.Node:
        """Make an instance of an object type, with all its mandatory members.

        :param optionals: paths of optional members below `path` that are made as well, as in
            `Status` and `Status/Parameter`; `ALL` for all of them
        """
        declared = self._server.get_node(type_id)
        node = await self._add(
            parent, declared, ua.NodeClass.Object, name, path, type_id, ua.ObjectIds.HasComponent
        )
        await self._fill(node, [declared], path, '', optionals)
        return node

    async def _fill(
        self,
        node: asyncua.Node,
        declarations: list[asyncua.Node],
        path: str,
        below: str,
        optionals: Collection[str],
    ) -> None:
        """Make the members of an object, a variable or a method.

        :param declarations: where they are declared: the nearest first, each with its supertypes
        """
        made: dict[str, tuple[asyncua.Node, list[asyncua.Node]]] = {}
        async for member in self._members(declarations):
            name = member.BrowseName.Name
            source = self._server.get_node(member.NodeId)
            if name in made:  # overridden nearby: that one is made, this one may have more members
                made[name][1].append(source)
                continue
            inner = f'{below}{name}'
            if not await self._is_wanted(source, inner, optionals):
                continue
            new = await self._add(
                node, source, member.NodeClass, member.BrowseName, f'{path}/{name}',
                member.TypeDefinition, member.ReferenceTypeId,
            )  # fmt: skip
            made[name] = new, [source]
        for name, (new, sources) in made.items():
            types = [await source.read_type_definition() for source in sources]
            known = [self._server.get_node(type_id) for type_id in dict.fromkeys(types) if type_id]
            inner = f'{below}{name}'
            await self._fill(new, [*sources, *known], f'{path}/{name}', f'{inner}/', optionals)

    async def _members(
        self, declarations: list[asyncua.Node]
    ) -> AsyncIterator[ua.ReferenceDescription]:
        for declared in declarations:
            node: asyncua.Node | None = declared
            while node is not None:
                for member in await node.get_children_descriptions():
                    if member.NodeClass in _COPIED:
                        yield member
                node = await self._supertype(node)

    async def _supertype(self, node: asyncua.Node) -> asyncua.Node | None:
        if await node.read_node_class() not in (
            ua.NodeClass.ObjectType,
            ua.NodeClass.VariableType,
        ):
            return None
        supertypes = await node.get_referenced_nodes(
            ua.ObjectIds.HasSubtype, ua.BrowseDirection.Inverse
        )
        return supertypes[0] if supertypes else None

    async def _is_wanted(
        self, source: asyncua.Node, inner: str, optionals: Collection[str]
    ) -> bool:
        rules = [
            rule.nodeid
            for rule in await source.get_referenced_nodes(ua.ObjectIds.HasModellingRule)
        ]
        if _MANDATORY in rules:
            return True
        return _OPTIONAL in rules and (optionals is ALL or inner in optionals)

    async def _add(
        self,
        parent: asyncua.Node,
        declared: asyncua.Node,
        node_class: ua.NodeClass,
        name: ua.QualifiedName,
        path: str,
        type_id: ua.NodeId,
        reference: ua.NodeId | int,
    ) -> asyncua.Node:
        make, copied = _COPIED[node_class]
        attributes = make()
        for bit in (_BITS.DisplayName, _BITS.Description, *copied):
            attribute = await declared.read_attribute(bit, raise_on_bad_status=False)
            if attribute.StatusCode.is_good() and attribute.Value is not None:
                value = attribute.Value if bit is _BITS.Value else attribute.Value.Value
                setattr(attributes, bit.name, value)
        if not attributes.Description.Text:
            attributes.Description = ua.LocalizedText(_MEANINGS.get(name.Name))
        item = ua.AddNodesItem()
        item.RequestedNewNodeId = ua.NodeId(path, self._namespace)
        item.BrowseName = name
        item.ParentNodeId = parent.nodeid
        item.ReferenceTypeId = ua.NodeId(reference) if isinstance(reference, int) else reference
        item.NodeClass = node_class
        item.TypeDefinition = type_id
        item.NodeAttributes = attributes
        (result,) = await self._server.iserver.isession.add_nodes([item])
        result.StatusCode.check()
        return self._server.get_node(result.AddedNodeId)
