"""The live view: the whole terminal, drawn again whenever there is something new."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap

from rich.console import Console, ConsoleOptions, Group, RenderResult
from rich.text import Text

from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.view.screen import blocks, words
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.blocks import Block
from bt_orchestrator.view.screen.fit import ASCII, UNICODE, Glyphs, heights
from bt_orchestrator.view.screen.keys import SecondScreen
from bt_orchestrator.view.screen.machine import Hearing
from bt_orchestrator.view.screen.view import CellView, cell_view

PACE_S = 0.5
"""Longest time between two drawings: times of running tasks go on without news."""


class LiveView:
    """Draws its content on the terminal's second screen."""

    def __init__(self, screen: SecondScreen, shell: Shell) -> None:
        self._screen = screen
        self._shell = shell
        self._notes: tuple[str, ...] = ()
        self._view: CellView | None = None
        self._tree: Branch | None = None
        self._blackboard: Mapping[str, str] | None = None
        self._hearing = Hearing(time.monotonic())
        self._is_new = False
        self._drawn_at = 0.0
        self._drawn_size = screen.size

    def on_status(self, status: CellStatus) -> None:
        """Show how the cell stands."""
        self._view = cell_view(status, self._shell)
        self._hearing.heard(time.monotonic())
        self._is_new = True

    def on_event(self, event: Event) -> None:
        """Show nothing: the status shows what an event changes."""

    def on_notes(self, notes: Sequence[str]) -> None:
        """Show lines below all else."""
        self._is_new |= self._notes != tuple(notes)
        self._notes = tuple(notes)

    def on_tree(self, tree: Branch) -> None:
        """Show the behaviour tree in place of the sections."""
        self._tree = tree
        self._is_new = True

    def on_blackboard(self, values: Mapping[str, str]) -> None:
        """Show the variables of the blackboard below all else."""
        self._blackboard = values
        self._is_new = True

    def refresh(self) -> None:
        """Draw, if there is something new, the terminal has another size, or time has passed."""
        now, size = time.monotonic(), self._screen.size
        is_due = now - self._drawn_at >= PACE_S or size != self._drawn_size
        if not (self._is_new or is_due):
            return
        self._is_new, self._drawn_at, self._drawn_size = False, now, size
        self._screen.show(self._picture(now))

    def _picture(self, now: float) -> Picture | Group:
        if self._view is None:
            age = words.duration(self._hearing.age_s(now))
            return Group(*map(Text, (f'waiting for {self._shell.node}, {age}', *self._notes)))
        silent_s = self._hearing.silent_s(now)
        age_s = 0.0 if silent_s is not None else self._hearing.age_s(now)
        return Picture(
            self._view,
            self._shell.node,
            age_s,
            silent_s,
            self._tree,
            self._blackboard,
            self._notes,
        )


# The whole picture of a cell, for a terminal of any size.

DISPLAYED = ('holds', 'next', 'troubles', 'jobs', 'body', 'blackboard', 'flags')
"""From top to bottom."""

IMPORTANCE = ('holds', 'next', 'body', 'jobs', 'troubles', 'blackboard', 'flags')
"""The order in which parts get room."""

ROOMY = 20
"""From so many lines on there are titles."""


@dataclass(frozen=True)
class Picture:
    """The knowledge at one moment. Draws itself in exactly the room that rich gives it."""

    view: CellView
    node: str
    age_s: float = 0.0
    """Since the status came: tasks have gone on meanwhile."""
    silent_s: float | None = None
    """Seconds since the node was last heard; None: all is well."""
    tree: Branch | None = None
    blackboard: Mapping[str, str] | None = None
    notes: Sequence[str] = ()
    """Lines below all else, which are always there."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        glyphs = ASCII if options.ascii_only else UNICODE
        room = options.height or console.height
        for line in self.lines(options.max_width, room, glyphs):
            if options.ascii_only:
                line.plain = line.plain.replace(UNICODE.ellipsis, ASCII.ellipsis)
            line.end = '\n'
            yield line

    def lines(self, width: int, room: int, glyphs: Glyphs = UNICODE) -> list[Text]:
        """Return the picture, no more lines than there is room for."""
        head = blocks.head(self.view, self.node, width, glyphs)
        for notice in self._notices():
            wrapped = wrap(notice, max(width, 20), max_lines=3)
            head += [Text(part, style='reverse bold') for part in wrapped]
        feet = [
            Text(part)
            for note in self.notes
            for part in wrap(note, max(width, 20), break_on_hyphens=False)
        ]
        parts = self._blocks(width, glyphs)
        lines = [*head, *_stacked(parts, width, room - len(head) - len(feet), glyphs)]
        lines = [*lines[: room - len(feet)], *feet][:room]
        for line in lines:
            line.truncate(width, overflow='ellipsis')
        return lines

    def _notices(self) -> Iterator[str]:
        if self.silent_s is not None:
            yield words.silence(self.node, self.silent_s)
        if self.view.failure:
            yield self.view.failure
        if self.view.in_local:
            yield self.view.in_local
        if self.view.stopped:
            yield self.view.stopped
        if self.view.stands:
            yield self.view.stands

    def _blocks(self, width: int, glyphs: Glyphs) -> dict[str, Block]:
        view = self.view
        parts = {'body': self._body(width, glyphs)}
        if view.holds:
            parts['holds'] = blocks.holds(view.holds, width, glyphs)
        if view.next_lines:
            parts['next'] = blocks.next_lines(view.next_lines, width)
        if view.troubles:
            parts['troubles'] = blocks.troubles(view, width, glyphs)
        if view.jobs:
            parts['jobs'] = blocks.jobs(view.jobs, width, glyphs, view.unlisted_jobs)
        if self.blackboard:
            parts['blackboard'] = blocks.blackboard(self.blackboard, width)
        if view.flags:
            parts['flags'] = blocks.flags(view, width)
        return parts

    def _body(self, width: int, glyphs: Glyphs) -> Block:
        """Return the sections; or the tree, which has a branch for each of them."""
        if self.tree is not None:
            return blocks.tree(self.tree, width, glyphs)
        return blocks.sections(self.view, self.age_s, width, glyphs)


def _stacked(parts: Mapping[str, Block], width: int, room: int, glyphs: Glyphs) -> Iterator[Text]:
    """Yield the lines of all parts; on a terminal of some height, each below its title."""
    titled = {name for name, part in parts.items() if part.title and room >= ROOMY}
    names = [name for name in IMPORTANCE if name in parts]
    wanted = [parts[name].wanted for name in names]
    least = [parts[name].least for name in names]
    given = dict(zip(names, heights(wanted, least, max(room - len(titled), 0)), strict=True))
    for name in DISPLAYED:
        if name in titled:
            yield _title(parts[name].title, width, glyphs)
        if given.get(name):
            yield from parts[name].draw(given[name])


def _title(title: str, width: int, glyphs: Glyphs) -> Text:
    ruled = Text(f'{title} {glyphs.rule * (width - len(title) - 1)}', style=blocks.QUIET)
    ruled.truncate(width)
    return ruled
