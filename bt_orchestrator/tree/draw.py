"""Drawings of a script, for a reviewer who did not write it."""

from __future__ import annotations

from dataclasses import dataclass

import graphviz

from bt_orchestrator.drawing.card import Sheet
from bt_orchestrator.drawing.line import line
from bt_orchestrator.drawing.line_state import LineState
from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.tree.draw_tree import tree

FORMATS = ('svg', 'png', 'pdf')
"""What `dot` is asked for; DOT text needs no `dot`."""

VIEWS = ('line', 'tree')
"""`line`: sections, tasks, flags and zones as a process; `tree`: the py_trees behaviours."""


class CannotDraw(OrchestratorError):
    """The program `dot` is missing, or failed."""


@dataclass(frozen=True)
class Drawing:
    """A drawing as DOT text; equal scripts and cells give equal texts."""

    dot: str
    engine: str
    """The layout program of Graphviz."""
    has_places: bool
    """Everything has its place in the text; nothing is left to lay out."""

    def image(self, kind: str) -> bytes:
        """Return the picture in one of FORMATS.

        :raises CannotDraw: there is no working `dot`
        """
        try:
            source = graphviz.Source(self.dot, engine=self.engine)
            return bytes(source.pipe(format=kind, neato_no_op=2 if self.has_places else None))
        except graphviz.ExecutableNotFound:
            hint = 'install Graphviz (`apt install graphviz`), or ask for a .dot file'
            raise CannotDraw(
                f'the program `dot` draws the picture and is missing; {hint}'
            ) from None
        except graphviz.CalledProcessError as error:
            said = error.stderr.decode(errors='replace').strip() if error.stderr else str(error)
            raise CannotDraw(f'`dot` could not draw the picture: {said}') from error


def draw(
    script: Script, cell: Cell, view: str = 'line', state: LineState | None = None
) -> Drawing:
    """Draw a script in its cell; nothing moves and nothing is asked but what is given.

    :param view: one of VIEWS
    :param state: the line at work, for the view `line`
    """
    sheet = Sheet(script, cell, state)
    if view == 'tree':
        return Drawing(tree(sheet).source, 'dot', has_places=False)
    return Drawing(line(sheet).source, 'neato', has_places=True)
