"""The drawing of the behaviour tree: the py_trees nodes of a script, types by shape."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Any, NamedTuple, NoReturn

import graphviz
from py_trees.behaviour import Behaviour
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Decorator

from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.engine.tree.leaf import ActionLeaf
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.view.drawing.card import Sheet, details
from bt_orchestrator.view.drawing.label import FAINT, FONT, INK, PAPER, Entry, Label, Text
from bt_orchestrator.view.drawing.picture import TreePicture
from bt_orchestrator.view.drawing.svg import xml_text

JOB = 'JOB'
"""Placeholder for the order that the script is run for."""


class Kind(NamedTuple):
    """How a kind of behaviour is drawn."""

    behaviour: type[Any]
    name: str
    shape: str
    shape_name: str
    fill: str
    style: str = 'filled'


KINDS = (
    Kind(Parallel, 'parallel', 'parallelogram', 'slanted box', '#e6ebf2'),
    Kind(Selector, 'selector', 'octagon', 'octagon', '#ede9fe'),
    Kind(Sequence, 'sequence', 'cds', 'arrow', '#dbeafe'),
    Kind(Decorator, 'decorator', 'box', 'rounded box', '#fef3c7', 'filled,rounded'),
    Kind(ActionLeaf, 'action', 'box', 'box', PAPER),
    Kind(Behaviour, 'condition or step of the engine', 'ellipse', 'ellipse', PAPER),
)
"""The first match is used."""


class Compiled:
    """The state of a cell with one order before its start. Implements `Recorder`."""

    now = 0.0

    def __init__(self, sheet: Sheet) -> None:
        self.state = CellState(sheet.cell)
        name, script = digest(sheet.script), sheet.script
        self.record(
            [
                e.ScriptLoaded(seq=1, script=script.name, digest=name, definition=script),
                e.JobQueued(seq=2, job=JOB, script=script.name, digest=name, quantity=1),
            ]
        )

    def record(self, events: Iterable[e.Event]) -> None:
        """Apply the drawing's own events."""
        for event in events:
            apply(self.state, event)

    def new_goal_id(self) -> NoReturn:
        """Nothing is ever ticked."""
        raise AssertionError('a drawing sends no goals')

    def server(self, component: str) -> NoReturn:
        """Nothing is ever ticked."""
        raise AssertionError(f'a drawing does not ask for {component}')

    def rivals(self, component: str) -> NoReturn:
        """Nothing is ever ticked."""
        raise AssertionError(f'a drawing does not ask for {component}')

    @property
    def uptime(self) -> NoReturn:
        """Nothing is ever ticked."""
        raise AssertionError('a drawing is on no machine')

    def is_delayed(self, key: e.TaskKey) -> NoReturn:
        """Nothing is ever ticked."""
        raise AssertionError(f'a drawing waits for nothing, not for {key}')

    awaits_setup = is_delayed


def draw_tree(script: Script, cell: Cell) -> TreePicture:
    """Draw a script's behaviour tree, from the root on the left to the leaves on the right."""
    sheet = Sheet(script, cell)
    graph = graphviz.Digraph(sheet.script.name, graph_attr=_page(sheet))
    graph.attr('node', fontname=FONT, fontsize='10', color=INK, fontcolor=INK, height='0.3')
    graph.attr('edge', color=FAINT, arrowhead='none')
    compiled = CellTree(Compiled(sheet), f'drawing of {sheet.script.name}', whole=True)
    try:
        _add(graph, sheet, compiled.root, 'root')
    finally:
        compiled.close()
    return TreePicture(str(graph.source))


def _page(sheet: Sheet) -> dict[str, str]:
    first = Text(f'{sheet.script.name}: behaviour tree', 22, bold=True)
    second = Text(f'for cell {sheet.cell.name}; {JOB} stands for an order', 12)
    return {
        'label': dot_label(Label(tuple((Entry((row,)),) for row in (first, second, *legend())))),
        'labelloc': 't',
        'labeljust': 'l',
        'fontname': FONT,
        'bgcolor': PAPER,
        'rankdir': 'LR',
        'ordering': 'out',
        'nodesep': '0.08',
        'ranksep': '0.3',
        'pad': '0.3',
        'tooltip': f'behaviour tree of script {sheet.script.name}',
    }


def _add(graph: graphviz.Digraph, sheet: Sheet, behaviour: Behaviour, path: str) -> None:
    kind = kind_of(behaviour)
    graph.node(
        path,
        graphviz.escape(behaviour.name),
        id=path,
        shape=kind.shape,
        style=kind.style,
        fillcolor=kind.fill,
        tooltip=_about(sheet, behaviour),
    )
    for number, child in enumerate(behaviour.children, 1):
        below = f'{path}.{number}'
        _add(graph, sheet, child, below)
        graph.edge(path, below)


def kind_of(behaviour: Behaviour) -> Kind:
    """Return how a behaviour is drawn."""
    return next(kind for kind in KINDS if isinstance(behaviour, kind.behaviour))


def _about(sheet: Sheet, behaviour: Behaviour) -> str:
    first = f'{kind_of(behaviour).name}: {behaviour.name} ({type(behaviour).__name__})'
    if not isinstance(behaviour, ActionLeaf):
        return tooltip([first])
    return tooltip([first, *details(sheet, behaviour.subject.task)])


def legend() -> list[Text]:
    """Explain the shapes, and how the tree is ticked."""
    shapes = ', '.join(f'{kind.shape_name}: {kind.name}' for kind in KINDS)
    order = 'children are ticked from top to bottom, which decides ties'
    return [Text(text, colour=FAINT) for text in (shapes, order)]


# --- labels and tooltips as Graphviz reads them: tables like HTML, text with backslashes ------


def dot_label(label: Label) -> str:
    """Return a label as an HTML-like table."""
    attributes = [f'BORDER="{label.border}"', 'CELLBORDER="0"', 'CELLSPACING="0"']
    attributes += [f'COLOR="{INK}"'] if label.border else []
    attributes += [f'BGCOLOR="{label.fill}"'] if label.fill else []
    attributes += ['STYLE="dashed"'] if label.dashed else []
    attributes += [f'HEIGHT="{label.height:g}"'] if label.height else []
    body = ''.join(f'<TR>{"".join(map(_entry, row))}</TR>' for row in label.rows)
    return f'<<TABLE {" ".join(attributes)}>{body}</TABLE>>'


def tooltip(lines: Iterable[str]) -> str:
    """Return lines for a tooltip, which is no HTML but knows backslashes."""
    return xml_text('\n'.join(line.replace('\\', '\\\\') for line in lines))


def _entry(entry: Entry) -> str:
    align = 'CENTER' if entry.centred else 'LEFT'
    attributes = [f'ALIGN="{align}"', f'BALIGN="{align}"', 'CELLPADDING="2"']
    attributes += [f'BGCOLOR="{entry.fill}"'] if entry.fill else []
    attributes += [f'COLSPAN="{entry.span}"'] if entry.span > 1 else []
    attributes += [f'WIDTH="{entry.width:g}"'] if entry.width else []
    attributes += [f'HEIGHT="{entry.height:g}"'] if entry.height else []
    content = f'<BR ALIGN="{align}"/>'.join(map(_text, entry.texts))
    if len(entry.texts) > 1:
        content += f'<BR ALIGN="{align}"/>'
    return f'<TD {" ".join(attributes)}>{content}</TD>'


def _text(text: Text) -> str:
    inner = html.escape(xml_text(text.text), quote=False)
    inner = f'<I>{inner}</I>' if text.italic else inner
    inner = f'<B>{inner}</B>' if text.bold else inner
    return f'<FONT POINT-SIZE="{text.size}" COLOR="{text.colour}">{inner}</FONT>'
