"""The verb `watch`: a running node, as it changes."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.events import Event
from bt_orchestrator.screen.advice import Shell
from bt_orchestrator.screen.viewer import Viewer
from bt_orchestrator.stop_signals import StopSignals

if TYPE_CHECKING:  # it needs rich, which takes its time
    from bt_orchestrator.screen.live import LiveView

Lines = TypeVar('Lines', bound=Viewer)

DESCRIPTION = """\
Show a running tree node until Ctrl-C: its belt, what every section does or waits for, jobs, flags,
components that are missing, and what an operator can answer to a hold. On a terminal the whole
screen, otherwise a line for each change."""


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
    from bt_orchestrator.ros.link.client import NodeClient

    with ExitStack() as stack:
        stop = stack.enter_context(StopSignals())
        client = stack.enter_context(NodeClient(args.node, args.timeout))
        client.status()  # a node that is not there, or has another name, is said at once
        viewer = stack.enter_context(_viewer(args, client.name))
        streams = _streams(args, client, viewer)
        follow(client, viewer)
        while not stop.requested:
            for stream in streams:
                stream.look()
            client.spin()
            viewer.refresh()
    return 0


def follow(client: Any, viewer: Viewer, also: Callable[[Event], object] | None = None) -> None:
    """Tell a viewer everything that a node says from now on.

    :param also: is told every event, too
    :raises NodeUnreachable: it is not there
    """
    client.on_status(viewer.on_status)
    follow_events(client, viewer, also)


def follow_events(
    client: Any, viewer: Viewer, also: Callable[[Event], object] | None = None
) -> None:
    """Tell a viewer every event from now on, as `follow` does."""

    def on_event(message: Any) -> None:
        event = from_record(json.loads(message.record))
        if also is not None:
            also(event)
        viewer.on_event(event)

    client.on_event(on_event)


@contextmanager
def live_or(other: Callable[[], Lines], shell: Shell) -> Iterator[LiveView | Lines]:
    """Open the live view if the standard output is a terminal, otherwise another one."""
    from bt_orchestrator.screen.live import LiveView, terminal

    # A name that the terminal's encoding does not have is no reason to stop.
    sys.stdout.reconfigure(errors='replace')  # type: ignore[union-attr]
    console = terminal()
    if console is None:
        yield other()
        return
    with LiveView(console, shell) as live:
        yield live


@contextmanager
def _viewer(args: argparse.Namespace, node: str) -> Iterator[Viewer]:
    """Open the view that was asked for."""
    from bt_orchestrator.screen.machine import JsonView
    from bt_orchestrator.screen.plain import PlainView

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


def _streams(args: argparse.Namespace, client: Any, viewer: Viewer) -> list[Any]:
    """Return what has to be asked of the inspection server."""
    if not (args.tree or args.blackboard):
        return []
    from bt_orchestrator.ros.link.inspection_streams import blackboard_stream, tree_stream
    from bt_orchestrator.screen.tree_view import tree_of

    def on_tree(behaviours: Any) -> None:
        tree = tree_of(behaviours)
        if tree is not None:
            viewer.on_tree(tree)

    streams = []
    if args.tree:
        streams.append(tree_stream(client.node, client.name, on_tree))
    if args.blackboard:
        streams.append(blackboard_stream(client.node, client.name, viewer.on_blackboard))
    return streams
