"""A finished drawing, and the files that can be made of it."""

from __future__ import annotations

from dataclasses import dataclass

import graphviz

from bt_orchestrator.errors import OrchestratorError

SVG, DOT = 'svg', 'dot'

FORMATS = (SVG, 'png', 'pdf', DOT)
"""Graphviz makes those that are neither SVG of our own nor DOT text."""


class CannotDraw(OrchestratorError):
    """The program `dot` is missing, or failed."""


@dataclass(frozen=True)
class Picture:
    """A drawing; equal scripts, cells and states give equal texts."""

    dot: str
    """The drawing as DOT text."""
    engine: str
    """The layout program of Graphviz."""
    has_places: bool = False
    """Everything has its place in the DOT text; nothing is left to lay out."""
    svg: str = ''
    """The drawing as SVG; empty: Graphviz lays it out, and writes that too."""

    def content(self, kind: str) -> bytes:
        """Return the file in one of FORMATS.

        :raises CannotDraw: there is no working `dot`, and it is needed
        """
        if kind == DOT:
            return self.dot.encode()
        if kind == SVG and self.svg:
            return self.svg.encode()
        return self._by_graphviz(kind)

    def _by_graphviz(self, kind: str) -> bytes:
        others = 'a .svg or .dot file' if self.svg else 'a .dot file'
        try:
            source = graphviz.Source(self.dot, engine=self.engine)
            return bytes(source.pipe(format=kind, neato_no_op=2 if self.has_places else None))
        except graphviz.ExecutableNotFound:
            hint = f'install Graphviz (`apt install graphviz`), or ask for {others}'
            raise CannotDraw(
                f'the program `dot` draws the picture and is missing; {hint}'
            ) from None
        except graphviz.CalledProcessError as error:
            said = error.stderr.decode(errors='replace').strip() if error.stderr else str(error)
            raise CannotDraw(
                f'`dot` could not draw the picture: {said}; ask for {others}'
            ) from error
