"""Writing placed things as DOT, where y grows upwards and every line is a spline."""

from __future__ import annotations

from collections.abc import Sequence

import graphviz

from bt_orchestrator.drawing.plan import Box
from bt_orchestrator.drawing.routes import Point
from bt_orchestrator.drawing.text import FONT, INK, PAPER, RULE

CORNER = 5.0
"""Radius of a bend."""
ARROW = 7.0
"""Length of an arrow's head."""
GROUP_LABEL = 10.0
"""From the upper edge of a group to the middle of its label."""


class Canvas:
    """A graph in which everything has its place, so that the engine has nothing to lay out."""

    def __init__(self, name: str, width: float, height: float) -> None:
        self.graph = graphviz.Digraph(name, comment='drawn with dot -Kneato -n2')
        self._height = height
        self.graph.attr(
            layout='neato',
            bb=self._bounds(Box(0, 0, width, height)),
            bgcolor=PAPER,
            fontname=FONT,
            outputorder='edgesfirst',
            pad='0.3',
            tooltip=f'script {name}',
        )
        self.graph.attr('node', shape='plain', fontname=FONT)
        self.graph.attr('edge', fontname=FONT, color=INK, arrowsize='0.7')

    def node(
        self, group: graphviz.Digraph, name: str, label: str, box: Box, **attributes: str
    ) -> None:
        """Draw a node around the middle of a box."""
        middle = self._point((box.middle, box.centre))
        group.node(name, label, pos=middle, id=name, **attributes)

    def group(
        self, parent: graphviz.Digraph, name: str, label: str, box: Box, **attributes: str
    ) -> graphviz.Digraph:
        """Return a context in which the members of a group are drawn."""
        attributes |= {
            'label': label,
            'lp': self._point((box.middle, box.top + GROUP_LABEL)),
            'bb': self._bounds(box),
            'style': 'filled,rounded',
            'color': RULE,
            'id': name,
        }
        return parent.subgraph(name=f'cluster.{name}', graph_attr=attributes)

    def line(
        self,
        start: str,
        end: str,
        points: Sequence[Point],
        *,
        head: bool = True,
        label_at: Point | None = None,
        **attributes: str,
    ) -> None:
        """Draw a line of points between two nodes, with an arrow at its end."""
        if label_at is not None:
            attributes['lp'] = self._point(label_at)
        if not head:
            attributes['arrowhead'] = 'none'
        self.graph.edge(start, end, pos=self._spline(points, head), **attributes)

    def _point(self, point: Point) -> str:
        return f'{point[0]:g},{self._height - point[1]:g}'

    def _bounds(self, box: Box) -> str:
        return f'{self._point((box.left, box.bottom))},{self._point((box.right, box.top))}'

    def _spline(self, points: Sequence[Point], head: bool) -> str:
        """Write a line with round corners; an arrow's head is not part of the curve."""
        tip = points[-1]
        corners = [*points[:-1], _towards(tip, points[-2], ARROW if head else 0)]
        controls = [corners[0]]
        for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
            near, far = _towards(corner, before, CORNER), _towards(corner, after, CORNER)
            controls += [controls[-1], near, near, corner, corner, far]
        controls += [controls[-1], corners[-1], corners[-1]]
        way = ' '.join(map(self._point, controls))
        return f'e,{self._point(tip)} {way}' if head else way


def _towards(start: Point, end: Point, length: float) -> Point:
    """Return a point on the way, at most half-way."""
    x, y = end[0] - start[0], end[1] - start[1]
    whole = (x * x + y * y) ** 0.5
    share = min(length / whole, 0.5) if whole else 0.0
    return round(start[0] + x * share, 1), round(start[1] + y * share, 1)
