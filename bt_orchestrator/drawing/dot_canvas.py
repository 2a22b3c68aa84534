"""A canvas that writes DOT text, from which Graphviz makes PNG and PDF.

In DOT y grows upwards and every line is a spline. Everything has its place, so that the layout
program has nothing to lay out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import graphviz

from bt_orchestrator.drawing.box import Box, Point
from bt_orchestrator.drawing.canvas import CORNER, HEADING, LineLabel, Stroke, towards
from bt_orchestrator.drawing.dot_label import dot_label, tooltip
from bt_orchestrator.drawing.label import Label
from bt_orchestrator.drawing.style import FONT, INK, PAPER, RULE

ARROW = 7.0
"""Length of an arrow's head, which is no part of the line."""

THICK = 3.0
"""From this width on the head of a line is as wide as the line asks for."""

THICK_TIP = 4.0
"""Room for the edge of such a head, which Graphviz draws around it."""


class DotCanvas:
    """Implements `Canvas`."""

    def __init__(self, name: str, size: Box, about: str) -> None:
        self._graph = self._here = graphviz.Digraph(name, comment='drawn with dot -Kneato -n2')
        self._height = size.height
        self._graph.attr(
            layout='neato',
            bb=self._bounds(size),
            bgcolor=PAPER,
            fontname=FONT,
            outputorder='edgesfirst',
            pad='0.3',
            tooltip=about,
        )
        self._graph.attr('node', shape='plain', fontname=FONT)
        self._graph.attr('edge', fontname=FONT, color=INK, arrowsize='0.7')

    def __str__(self) -> str:
        return str(self._graph.source)

    @contextmanager
    def frame(
        self, name: str, heading: Label, box: Box, fill: str, about: Sequence[str]
    ) -> Iterator[None]:
        """Draw a frame; what is drawn within the context stands in it."""
        attributes = {
            'fillcolor': fill,
            'tooltip': tooltip(about),
            'label': dot_label(heading),
            'lp': self._point((box.middle, box.top + HEADING)),
            'bb': self._bounds(box),
            'style': 'filled,rounded',
            'color': RULE,
            'id': name,
        }
        around = self._here
        with around.subgraph(name=f'cluster.{name}', graph_attr=attributes) as self._here:
            yield
        self._here = around

    def label(self, name: str, label: Label, box: Box, about: Sequence[str]) -> None:
        """Draw a table of text around the middle of a box."""
        self._node(name, dot_label(label), box, tooltip=tooltip(about))

    def point(self, name: str, box: Box, about: Sequence[str]) -> None:
        """Draw a small dot where lines meet."""
        looks = {'shape': 'point', 'width': '0.06', 'color': INK}
        self._node(name, '', box, **looks, tooltip=tooltip(about))

    def line(
        self,
        ends: tuple[str, str],
        points: Sequence[Point],
        stroke: Stroke,
        *,
        name: str = '',
        about: Sequence[str] = (),
        label: LineLabel | None = None,
    ) -> None:
        """Draw a line with round corners from one part to another."""
        attributes = {'id': name, 'edgetooltip': tooltip(about)} if name else {}
        if stroke.width != 1.0:
            attributes |= {'penwidth': f'{stroke.width:g}'}
        if stroke.width > THICK:
            attributes |= {'arrowsize': '0.6'}
            points = [*points[:-1], towards(points[-1], points[-2], THICK_TIP)]
        if stroke.colour != INK:
            attributes |= {'color': stroke.colour}
        if stroke.dashed:
            attributes |= {'style': 'dashed'}
        if not stroke.head:
            attributes |= {'arrowhead': 'none'}
        if label is not None:
            words = {'label': dot_label(label.label), 'labeltooltip': tooltip(about)}
            attributes |= {**words, 'lp': self._point(label.at)}
        self._graph.edge(*ends, pos=self._spline(points, stroke.head), **attributes)

    def _node(self, name: str, label: str, box: Box, **attributes: str) -> None:
        middle = self._point((box.middle, box.centre))
        self._here.node(name, label, pos=middle, id=name, **attributes)

    def _point(self, point: Point) -> str:
        return f'{point[0]:g},{self._height - point[1]:g}'

    def _bounds(self, box: Box) -> str:
        return f'{self._point((box.left, box.bottom))},{self._point((box.right, box.top))}'

    def _spline(self, points: Sequence[Point], head: bool) -> str:
        """Write a line with round corners; an arrow's head is not part of the curve."""
        tip = points[-1]
        corners = [*points[:-1], towards(tip, points[-2], ARROW if head else 0)]
        controls = [corners[0]]
        for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
            near, far = towards(corner, before, CORNER), towards(corner, after, CORNER)
            controls += [controls[-1], near, near, corner, corner, far]
        controls += [controls[-1], corners[-1], corners[-1]]
        way = ' '.join(map(self._point, controls))
        return f'e,{self._point(tip)} {way}' if head else way
