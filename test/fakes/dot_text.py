"""Drawings as DOT text, read back."""

from __future__ import annotations

import re
from collections.abc import Mapping
from html import unescape
from typing import NamedTuple

_VALUE = r'(?:<<TABLE.*?</TABLE>>|"(?:[^"\\]|\\.)*"|[^\s\]"<]+)'


class Area(NamedTuple):
    """A rectangle, y upwards."""

    left: float
    bottom: float
    right: float
    top: float

    def holds(self, other: Area) -> bool:
        return (
            self.left <= other.left
            and self.right >= other.right
            and self.bottom <= other.bottom
            and self.top >= other.top
        )

    def meets(self, other: Area) -> bool:
        return (
            self.left < other.right
            and other.left < self.right
            and self.bottom < other.top
            and other.bottom < self.top
        )


class DotText:
    """The statements of a drawing: attributes by node, by edge `a -> b`, by cluster."""

    def __init__(self, text: str) -> None:
        self.nodes: dict[str, Mapping[str, str]] = {}
        self.edges: dict[str, Mapping[str, str]] = {}
        self.clusters: dict[str, Mapping[str, str]] = {}
        cluster = ''
        for statement in re.split(r'\n(?=\t)', text):
            line = statement.strip()
            if opened := re.match(r'subgraph "?cluster\.([\w.-]+)"? \{', line):
                cluster = opened[1]
            elif cluster and cluster not in self.clusters and '=' in line:
                self.clusters[cluster] = attributes(line)
            elif edge := re.match(r'"?([\w.-]+)"? -> "?([\w.-]+)"?', line):
                self.edges[f'{edge[1]} -> {edge[2]}'] = attributes(line[edge.end() :])
            elif node := re.match(r'"?([\w.-]+)"? \[', line):
                self.nodes[node[1]] = attributes(line[node.end() :])

    def words(self, node: str) -> list[str]:
        """Return what is written on a node, line by line."""
        return words(self.nodes[node]['label'])

    def place(self, node: str) -> tuple[float, float]:
        """Return where the middle of a node is."""
        x, y = self.nodes[node]['pos'].split(',')
        return float(x), float(y)

    def card(self, task: str) -> Area:
        """Return the place of a task's card."""
        x, y = self.place(f'task.{task}')
        label = self.nodes[f'task.{task}']['label']
        height = re.match(r'<<TABLE [^>]*HEIGHT="([\d.]+)"', label)
        width = re.search(r'COLSPAN="2" WIDTH="([\d.]+)"', label)
        assert height
        assert width
        half, middle = float(width[1]) / 2, float(height[1]) / 2
        return Area(x - half, y - middle, x + half, y + middle)

    def area(self, cluster: str) -> Area:
        """Return the place of a group."""
        return Area(*map(float, self.clusters[cluster]['bb'].split(',')))


def attributes(text: str) -> dict[str, str]:
    """Return the attributes of a statement."""
    pairs = re.findall(rf'(\w+)=({_VALUE})', text, re.DOTALL)
    return {key: value.strip('"').replace('\\"', '"') for key, value in pairs}


def words(label: str) -> list[str]:
    """Return the lines of an HTML-like label."""
    lines = re.split(r'<BR[^>]*/>|</TD>', label)
    plain = (unescape(re.sub(r'<[^>]*>', '', line)).strip('<> ') for line in lines)
    return [line for line in plain if line]
