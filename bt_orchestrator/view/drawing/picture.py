"""A finished drawing, and the files that can be made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import graphviz

from bt_orchestrator.base.errors import OrchestratorError

SVG, PNG, PDF, DOT = 'svg', 'png', 'pdf', 'dot'

FORMATS = (SVG, PNG, PDF, DOT)
"""DOT is the text of a behaviour tree alone."""

PIXELS_A_POINT = 2.0
"""A PNG of 144 pixels an inch: sharp on paper and on screens."""

CSS_PIXELS_A_POINT = 96 / 72
"""CairoSVG writes so many by itself."""


class CannotDraw(OrchestratorError):
    """The picture has no such format, or the program or library that makes it is missing."""


class Picture(Protocol):
    """A drawing. Equal scripts, cells and states give equal texts."""

    def content(self, kind: str) -> bytes:
        """Return the file in one of FORMATS.

        :raises CannotDraw: the file cannot be made; the message says what to do
        """


@dataclass(frozen=True)
class LinePicture:
    """The drawing of a line: SVG written here; CairoSVG makes PNG and PDF of it."""

    svg: str

    def content(self, kind: str) -> bytes:
        """Return the file in one of FORMATS, except DOT.

        :raises CannotDraw: CairoSVG is missing, and it is needed
        """
        if kind == SVG:
            return self.svg.encode()
        try:
            import cairosvg  # here, because pages and most verbs start without it
        except (ImportError, OSError) as error:
            raise CannotDraw(
                f'PNG and PDF need CairoSVG, which does not load ({error}); install it '
                '(`apt install python3-cairosvg`, or `pip install cairosvg` and '
                '`apt install libcairo2`), or ask for a .svg file'
            ) from None
        convert, scale = {
            PNG: (cairosvg.svg2png, PIXELS_A_POINT / CSS_PIXELS_A_POINT),
            PDF: (cairosvg.svg2pdf, 1.0),
        }[kind]
        return bytes(convert(self.svg.encode(), scale=scale))


@dataclass(frozen=True)
class TreePicture:
    """The drawing of a behaviour tree: DOT text, which Graphviz lays out."""

    dot: str

    def content(self, kind: str) -> bytes:
        """Return the file in one of FORMATS.

        :raises CannotDraw: there is no working `dot`, and it is needed
        """
        if kind == DOT:
            return self.dot.encode()
        try:
            return bytes(graphviz.Source(self.dot).pipe(format=kind))
        except graphviz.ExecutableNotFound:
            raise CannotDraw(
                'the program `dot` draws the behaviour tree and is missing; install Graphviz '
                '(`apt install graphviz`), or ask for a .dot file'
            ) from None
        except graphviz.CalledProcessError as error:
            message = error.stderr.decode(errors='replace').strip() if error.stderr else str(error)
            raise CannotDraw(
                f'`dot` could not draw the picture: {message}; ask for a .dot file'
            ) from error
