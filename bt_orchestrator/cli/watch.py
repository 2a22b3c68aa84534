"""The verb `watch`: a running node, as it changes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, TypeVar

from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.door import STEP_S, Ignoring, open_door
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.machine import Viewer
from bt_orchestrator.view.screen.plain import printable

if TYPE_CHECKING:  # it needs rich, which takes its time
    from bt_orchestrator.view.screen.live import LiveView

Lines = TypeVar('Lines', bound=Viewer)

DESCRIPTION = """\
Show a running tree node until Ctrl-C: belt, jobs, flags, the work and waits of each section,
missing components, and the possible answers to holds. On a terminal it fills the screen,
otherwise it prints a line for each change."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument(
        '--tree', action='store_true', help='the behaviour tree in place of the sections'
    )
    parser.add_argument('--blackboard', action='store_true', help='the blackboard as well')
    parser.add_argument(
        '--plain', action='store_true', help='a line for each change, also on a terminal'
    )
    parser.add_argument(
        '--json', action='store_true', help='one JSON object a line for each change, for machines'
    )
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    with ExitStack() as stack:
        stop = stack.enter_context(StopSignals())
        door = stack.enter_context(open_door(args.node, args.timeout))
        door.status()  # a node that is not there, or has another name, is said at once
        viewer = stack.enter_context(_viewer(args, door.name))
        if args.tree:
            door.watch_tree(lambda tree: viewer.on_tree(printable(tree)))
        if args.blackboard:
            door.watch_blackboard(viewer.on_blackboard)
        door.follow(Watching(viewer))
        while not stop.requested:
            door.turn(STEP_S)
            viewer.refresh()
    return 0


class Watching(Ignoring):
    """Tells a viewer what happens from now on.

    Of a node with another journal that is what comes after its first status, and not all that has
    ever happened there.
    """

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._known: int | None = 0
        """Last event that is no news; None: to be heard with the next status."""

    def on_status(self, status: CellStatus) -> None:
        """Show how the cell stands."""
        if self._known is None:
            self._known = status.seq
        self._viewer.on_status(status)

    def on_event(self, event: Event) -> None:
        """Show what happened."""
        if self._known is not None and event.seq > self._known:
            self._viewer.on_event(event)

    def on_history(self, history: str) -> None:  # noqa: ARG002 - the port's
        """Begin anew."""
        self._known = None


@contextmanager
def live_or(other: Callable[[], Lines], shell: Shell) -> Iterator[LiveView | Lines]:
    """Open the live view if the standard output is a terminal, otherwise another one."""
    from bt_orchestrator.view.screen.keys import second_screen
    from bt_orchestrator.view.screen.live import LiveView

    # A name that the terminal cannot encode must not end the view.
    sys.stdout.reconfigure(errors='replace')  # type: ignore[union-attr]
    with second_screen() as screen:
        yield other() if screen is None else LiveView(screen, shell)


@contextmanager
def _viewer(args: argparse.Namespace, node: str) -> Iterator[Viewer]:
    """Open the view that was asked for."""
    from bt_orchestrator.view.screen.machine import JsonView
    from bt_orchestrator.view.screen.plain import PlainView

    shell = Shell(node)
    if args.json:
        yield JsonView(node, say)
    elif args.plain:
        yield PlainView(shell, say)
    else:
        with live_or(lambda: PlainView(shell, say), shell) as viewer:
            yield viewer


def say(text: str) -> None:
    """Print a line at once."""
    print(text, flush=True)
