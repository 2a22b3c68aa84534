"""Instances of the types of the nodesets, against what the nodesets declare."""

from __future__ import annotations

import asyncua
from asyncua import ua
from fakes.bare_space import BareSpace

from bt_orchestrator.extensions.opcua.server import instances, nodesets
from bt_orchestrator.extensions.opcua.server.space import Space

RECEIVER, PACK_ML = 1008, 6
"""Ids of types: ISA95JobOrderReceiverSubStatesType, and PackMLBaseObjectType."""


def type_of(space: Space, nodeset: nodesets.Nodeset, number: int) -> ua.NodeId:
    return ua.NodeId(number, space.ns[nodeset.uri])


async def paths(node: asyncua.Node) -> set[str]:
    """Return the ids of everything below a node."""
    ids = set()
    for child in await node.get_children():
        ids |= {str(child.nodeid.Identifier), *await paths(child)}
    return ids


def test_object_has_mandatory_and_named_optional_members(
    in_space: BareSpace,
) -> None:
    async def look(space: Space) -> None:
        wanted = type_of(space, nodesets.JOB_CONTROL, RECEIVER)
        await space.instance(space.cell, wanted, 'Few', 'Few', optionals=('Store',))
        few = await paths(space.node('Few'))
        assert {'Few/JobOrderList', 'Few/CurrentState/Id', 'Few/Store'} <= few
        assert {'Few/Store/InputArguments', 'Few/Store/OutputArguments'} <= few
        assert not any(path.startswith('Few/Start') for path in few)
        await space.instance(space.cell, wanted, 'All', 'All', optionals=instances.ALL)
        everything = await paths(space.node('All'))
        methods = {'Store', 'StoreAndStart', 'Start', 'RevokeStart', 'Update', 'Pause', 'Resume'}
        methods |= {'Stop', 'Abort', 'Cancel', 'Clear'}
        assert {f'All/{method}/InputArguments' for method in methods} <= everything

    in_space(look)


def test_nested_objects_are_whole(in_space: BareSpace) -> None:
    async def look(space: Space) -> None:
        wanted = type_of(space, nodesets.PACK_ML, PACK_ML)
        await space.instance(space.cell, wanted, 'PackML', 'PackML')
        below = await paths(space.node('PackML'))
        machine = 'PackML/BaseStateMachine/MachineState'
        assert f'{machine}/ExecuteState/CurrentState/Id' in below
        assert 'PackML/Status/EquipmentStarved' in below
        assert 'PackML/Status/CurMachSpeed/EURange' in below

    in_space(look)


def test_member_matches_types_and_names_of_declaration(in_space: BareSpace) -> None:
    async def look(space: Space) -> None:
        wanted = type_of(space, nodesets.JOB_CONTROL, RECEIVER)
        node = await space.instance(space.cell, wanted, 'Jobs', 'Jobs', optionals=instances.ALL)
        assert await node.read_type_definition() == wanted
        index = space.ns[nodesets.JOB_CONTROL.uri]
        for name in ('JobOrderList', 'Store'):
            made = space.node(f'Jobs/{name}')
            declared = await declaration(space, name)
            assert await made.read_browse_name() == ua.QualifiedName(name, index)
            assert await made.read_description() == await declared.read_description()
        jobs, declared = space.node('Jobs/JobOrderList'), await declaration(space, 'JobOrderList')
        assert await jobs.read_data_type() == await declared.read_data_type()
        assert await jobs.read_value_rank() == await declared.read_value_rank()

    in_space(look)


async def declaration(space: Space, name: str) -> asyncua.Node:
    """Return a member of the receiver's type, or of its supertype."""
    index = space.ns[nodesets.JOB_CONTROL.uri]
    for number in (RECEIVER, 1002):
        for child in await space.server.get_node(ua.NodeId(number, index)).get_children():
            if (await child.read_browse_name()).Name == name:
                return child
    raise AssertionError(name)
