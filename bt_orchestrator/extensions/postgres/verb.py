"""The verb `feed`: a cell's journal, copied into the database of the plant."""

from __future__ import annotations

import argparse
import os
import socket
import sys
import threading
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from bt_orchestrator.base.errors import JournalUnusable, NodeUnreachable
from bt_orchestrator.base.extending import POSTGRES
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.node_options import add_node_options, user_name
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.keeping.journal_place import journal_place

if TYPE_CHECKING:  # they need psycopg
    from bt_orchestrator.extensions.postgres.connecting import Connection, Place
    from bt_orchestrator.extensions.postgres.feed import Copied, Feed
    from bt_orchestrator.extensions.postgres.sources import DoorSource, FileSource


POLL_S = 1.0
"""Time between two looks at a journal that is followed."""

TABLES_EVERY = 10
"""The other tables of a followed journal are compared at every tenth look."""

RETRY_S = 2.0
"""Time after which something that was away is tried again."""

DESCRIPTION = """\
Copy the journal of a cell into the database of the plant (PostgreSQL): all events, in order. With
--journal this includes jobs, books and states; without it, it is the events of a running node.
The verb goes on where it was, so it may be stopped, killed and started at any time, and the line
never notices. With --follow it goes on with what comes, and waits for a database that is away.
The copy is for reports: no node can go on from it. More: docs/plant.md."""

EPILOG = """\
exit status: 0 copied, 1 refused, or events are missing in the copy, 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        '--to',
        type=journal_place,
        required=True,
        metavar='ADDRESS',
        help='the database, for instance postgresql://plant_feed@dbhost/plant, and behind another '
        'slash the name of the cell there (default: the name in its cell file)',
    )
    parser.add_argument(
        '--journal',
        type=Path,
        metavar='FILE',
        help='the journal file, whether a node has it or not (default: the events of a running '
        'node)',
    )
    parser.add_argument('--follow', action='store_true', help='go on until Ctrl-C')
    parser.add_argument(
        '--page', metavar='URL', help='address of the operator page of the cell, for overviews'
    )
    parser.add_argument(
        '--list',
        action='store_true',
        help='copy nothing: list the cells and how old their copy is',
    )
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    POSTGRES.demand()
    from bt_orchestrator.extensions.postgres.connecting import place_of
    from bt_orchestrator.extensions.postgres.schema import CellRefused

    if args.list:
        return _list(str(args.to))
    if args.page is not None and not args.page.startswith(('http://', 'https://')):
        raise WrongUse(f'expected the address of a page, http://HOST:PORT/, found {args.page!r}')
    feeding = _Feeding(args, place_of(str(args.to)))
    with StopSignals() as stop, closing(feeding):
        stopped = threading.Event()
        stop.notify(stopped.set)
        teller, turns, lost = _Teller(), 0, 0
        while True:
            try:
                done = feeding.turn(with_tables=turns % TABLES_EVERY == 0)
            except (JournalUnusable, NodeUnreachable) as error:
                if not args.follow or isinstance(error, CellRefused):
                    raise
                teller.is_away(str(error))
                feeding.close()
                turns = 0
                if stopped.wait(RETRY_S):
                    return 1
                continue
            lost += len(done.gaps)
            teller.is_there(done, feeding)
            turns += 1
            if stopped.wait(POLL_S) if args.follow else True:
                break
        if not args.follow:
            print(f'{feeding.what}: {done.events} events copied, up to event {feeding.reached}')
        return 1 if lost else 0


class _Feeding:
    """The two ends of a feed, opened when they are needed, and again after they were away."""

    def __init__(self, args: argparse.Namespace, place: Place) -> None:
        self._args = args
        self._place = place
        self._source: FileSource | DoorSource | None = None
        self._connection: Connection | None = None
        self._feed: Feed | None = None

    @property
    def what(self) -> str:
        """Names the cell in its database."""
        return str(self._place)

    @property
    def reached(self) -> int:
        """The last event that was copied."""
        return self._feed.reached if self._feed is not None else 0

    def turn(self, *, with_tables: bool) -> Copied:
        """Copy what is new.

        :raises JournalUnusable: one end of it cannot be used now
        :raises NodeUnreachable: the node does not answer
        """
        from bt_orchestrator.extensions.postgres.connecting import speaking_of

        source = self._open_source()
        with speaking_of(self._place):
            feed = self._open_feed(source)
            done = feed.copy_events(source)
            if self._args.journal is not None and (with_tables or done.gaps):
                feed.copy_tables(self._args.journal, done)
            feed.is_complete()
        return done

    def close(self) -> None:
        """Close both ends."""
        source, self._source = self._source, None
        connection, self._connection = self._connection, None
        self._feed = None
        if source is not None:
            source.close()
        if connection is not None:
            connection.close()

    def _open_source(self) -> FileSource | DoorSource:
        from bt_orchestrator.extensions.postgres.sources import DoorSource, FileSource

        args = self._args
        if self._source is not None and self._source.is_replaced:
            self._source.close()
            self._source = None
        if self._source is None:
            if args.journal is not None:
                self._source = FileSource(args.journal)
            else:
                self._source = DoorSource(open_door(args.node, args.timeout))
        return self._source

    def _open_feed(self, source: FileSource | DoorSource) -> Feed:
        from bt_orchestrator.extensions.postgres.connecting import connected
        from bt_orchestrator.extensions.postgres.feed import Feed
        from bt_orchestrator.extensions.postgres.schema import FEED, enter

        if self._feed is not None:
            return self._feed
        name = self._place.cell or source.cell_name()
        if not name:
            raise WrongUse(
                'the journal does not name its cell; name it behind the database: --to '
                f'{self._place.of("CELL")}'
            )
        self._place = self._place.of(name)
        self._connection = connected(self._place, f'feed {name}')
        holder = f'feed of {user_name()}@{socket.gethostname()}, process {os.getpid()}'
        cell = enter(self._connection, name, FEED, holder)
        if self._args.page is not None:
            self._connection.execute(
                'UPDATE plant.cells SET page = %s WHERE number = %s',
                (self._args.page, cell.number),
            )
        self._feed = Feed(self._connection, cell)
        return self._feed


class _Teller:
    """Tells a person what changes, each once."""

    def __init__(self) -> None:
        self._away = ''

    def is_away(self, why: str) -> None:
        """Say that the feed waits."""
        if why != self._away:
            self._away = why
            print(f'{why}; waiting', file=sys.stderr, flush=True)

    def is_there(self, done: Copied, feeding: _Feeding) -> None:
        """Say that it goes on, and what will never come."""
        if self._away:
            self._away = ''
            what = f'{feeding.what}: goes on, {done.events} events copied'
            print(what, file=sys.stderr, flush=True)
        for gap in done.gaps:
            print(f'{feeding.what}: {gap}', file=sys.stderr, flush=True)


def _list(address: str) -> int:
    from bt_orchestrator.extensions.postgres.overview import cells_of

    for cell in cells_of(address):
        behind = cell.behind_s
        age = 'never complete' if behind is None else f'complete {behind:.0f} s ago'
        missing = f', {cell.gaps} gaps' if cell.gaps else ''
        state = cell.state or 'no state yet'
        print(f'{cell.name}  {state}  up to event {cell.last_seq}, {age}{missing}')
    return 0
