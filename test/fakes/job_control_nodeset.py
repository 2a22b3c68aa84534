"""The nodeset of ISA-95 Job Control, read without an OPC UA library."""

from __future__ import annotations

import gzip
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from functools import lru_cache
from importlib.resources import files

_NS = {'u': 'http://opcfoundation.org/UA/2011/03/UANodeSet.xsd'}

RECEIVER, INTERRUPTED, PREPARE = 'ns=1;i=1008', 'ns=1;i=1007', 'ns=1;i=1001'
"""ISA95JobOrderReceiverSubStatesType, and the types of its machines InterruptedSubstates and
AllowedToStartSubstates."""


@lru_cache
def nodes() -> dict[str, ET.Element]:
    """Return all nodes by their ids."""
    path = files('o6_nodeset_compiler') / 'bundle' / 'isa95_jobcontrol_v2.xml.gz'
    root = ET.fromstring(gzip.decompress(path.read_bytes()))
    return {node.get('NodeId', ''): node for node in root if node.get('NodeId')}


def name_of(node: ET.Element) -> str:
    """Return the browse name of a node, without its namespace."""
    return node.get('BrowseName', '').rpartition(':')[2]


def members(parent: str) -> Iterator[ET.Element]:
    """Yield the nodes that a node has."""
    return (node for node in nodes().values() if node.get('ParentNodeId') == parent)


def state_numbers(machine: str) -> dict[str, int]:
    """Return the number of every state of a type, by its name."""
    return {
        name_of(state): int(''.join(number.itertext()).split()[-1])
        for state in members(machine)
        for number in members(state.get('NodeId', ''))
        if name_of(number) == 'StateNumber'
    }
