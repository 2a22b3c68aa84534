"""Every node of a cell says what it is."""

from __future__ import annotations

from collections.abc import AsyncIterator

import asyncua
from asyncua import ua
from opcua_reader import Reader, reading


async def _below(node: asyncua.Node, path: str = '') -> AsyncIterator[tuple[str, asyncua.Node]]:
    for child in await node.get_children(refs=ua.ObjectIds.HierarchicalReferences):
        name = f'{path}/{(await child.read_browse_name()).Name}'
        yield name, child
        async for descendant in _below(child, name):
            yield descendant


def test_every_cell_node_has_description(url: str) -> None:
    async def look(reader: Reader) -> None:
        tops = [
            obj
            for obj in await reader.client.nodes.objects.get_children()
            if obj.nodeid.NamespaceIndex == reader.idx
        ]
        descendants = [(name, obj) for top in tops async for name, obj in _below(top)]
        nodes = [*descendants, *((obj.nodeid.Identifier, obj) for obj in tops)]
        assert len(nodes) > 200
        silent = [
            name for name, obj in nodes if not ((await obj.read_description()).Text or '').strip()
        ]
        assert not silent, '\n'.join(silent)

    reading(url, look)
