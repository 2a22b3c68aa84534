"""The second screen of a terminal, on which a picture is drawn again and again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, ConsoleDimensions, RenderableType
from rich.live import Live


class SecondScreen:
    """The screen while it is taken; see `second_screen`."""

    def __init__(self, console: Console, live: Live) -> None:
        self._console = console
        self._live = live

    @property
    def size(self) -> ConsoleDimensions:
        """Columns and lines of the present terminal."""
        return self._console.size

    def show(self, picture: RenderableType) -> None:
        """Draw a picture in place of the one before."""
        self._live.update(picture, refresh=True)


@contextmanager
def second_screen() -> Iterator[SecondScreen | None]:
    """Take the second screen of the terminal, and give the first one back at the end.

    None: the standard output is no terminal on which a picture can be drawn.
    """
    console = Console()
    if console.is_dumb_terminal or not console.is_terminal:
        yield None
        return
    live = Live(console=console, screen=True, auto_refresh=False, redirect_stdout=False)
    with live:
        yield SecondScreen(console, live)
