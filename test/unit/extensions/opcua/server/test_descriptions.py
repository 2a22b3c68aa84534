"""Every node of a cell says what it is."""

from __future__ import annotations

from collections.abc import AsyncIterator

import asyncua
from asyncua import ua
from opcua_reader import Reader, reading


async def _below(node: asyncua.Node, path: str = '') -> AsyncIterator[tuple[str, asyncua.Node]]:
    for one in await node.get_children(refs=ua.ObjectIds.HierarchicalReferences):
        name = f'{path}/{(await one.read_browse_name()).Name}'
        yield name, one
        async for found in _below(one, name):
            yield found


def test_every_node_of_a_cell_says_what_it_is(url: str) -> None:
    async def look(reader: Reader) -> None:
        tops = [
            one
            for one in await reader.client.nodes.objects.get_children()
            if one.nodeid.NamespaceIndex == reader.idx
        ]
        found = [(name, one) for top in tops async for name, one in _below(top)]
        nodes = [*found, *((one.nodeid.Identifier, one) for one in tops)]
        assert len(nodes) > 200
        silent = [
            name for name, one in nodes if not ((await one.read_description()).Text or '').strip()
        ]
        assert not silent, '\n'.join(silent)

    reading(url, look)
