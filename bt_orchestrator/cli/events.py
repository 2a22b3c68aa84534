"""The verb `events`: what happens at a running node, or what a journal says happened."""

from __future__ import annotations

import argparse
import itertools
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import IO

from bt_orchestrator.base.extending import PARQUET, of_others
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.door import STEP_S, Ignoring, open_door
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.numbers import add_period_options, whole
from bt_orchestrator.cli.output import WrongUse, cannot_write, opened
from bt_orchestrator.cli.reporting.each_cell import each_cell, with_cell
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event, OrchestratorStarted
from bt_orchestrator.model.keeping.journal_place import journal_place
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.exports import OUTPUTS, Output, Timed
from bt_orchestrator.view.report.reading import Reading, removed

POLL_S = 0.2
"""Time between two looks into a journal that is followed."""

QUIET_S = 1.0
"""After so long without an event a person reads that this is no fault."""

DESCRIPTION = """\
Print every event of a running tree node from now on, one JSON object a line, until Ctrl-C. With
--since-seq also those before, without a gap: events that the topic lost are fetched from the
node's journal. If a node comes back with another journal, it is followed from its first event on,
and stderr says so. With --journal read a journal file instead, whether its node runs or not, and
end."""

EPILOG = """\
xes: one trace an item, the tasks are the activities (IEEE 1849-2016).
csv: one row an event.
parquet: the tables events.parquet, one row an event, and tasks.parquet, one row an attempt of a
task, in the folder of -o.

exit status: 0 everything was printed, 1 something was not (of a damaged journal, say), 2 wrong
use"""

_OF_JOURNAL = ('job', 'event', 'since', 'until', 'follow', 'output', 'format')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('--count', type=whole, metavar='N', help='end after N events')
    parser.add_argument(
        '--since-seq', type=whole, metavar='SEQ', help='begin after this sequence number'
    )
    parser.add_argument(
        '--last', type=whole, metavar='N', help='begin with the last N events that there are'
    )
    parser.add_argument('--journal', type=journal_place, metavar='FILE', help='read this journal')
    parser.add_argument('--job', metavar='JOB', help='with --journal: of this job only')
    parser.add_argument(
        '--event',
        action='append',
        metavar='NAME',
        help='with --journal: of this name only, task. for all of tasks; may be repeated',
    )
    add_period_options(parser, 'with --journal:')
    parser.add_argument(
        '--follow', action='store_true', help='with --journal: go on with what is added to it'
    )
    parser.add_argument(
        '--format',
        choices=_Formats((*OUTPUTS, PARQUET.name)),
        help='with --journal: how it is written (default jsonl)',
    )
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE',
        help='with --journal: where; of parquet the folder',
    )
    add_node_options(parser)


class _Formats(tuple[str, ...]):
    """Our formats; those of other packages are looked up when somebody names one."""

    __slots__ = ()

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or name in of_others('exports')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    _refuse_contradictions(args)
    with StopSignals() as stop:
        if args.journal is None:
            return _of_node(args, stop)
        return each_cell(args, partial(_of_journal, stop), one_only=('follow', 'format', 'output'))


def _refuse_contradictions(args: argparse.Namespace) -> None:
    if args.last is not None and args.since_seq is not None:
        raise WrongUse('--last and --since-seq both say where to begin; leave one of them out')
    if args.journal is None and any(getattr(args, name) for name in _OF_JOURNAL):
        raise WrongUse('filters, --follow, --format and -o are for a journal: add --journal FILE')
    name = args.format or 'jsonl'
    is_parquet = name == PARQUET.name
    if args.follow and (is_parquet or getattr(_export(name), 'at_end', False)):
        raise WrongUse(f'{name} is written when all events are known; leave --follow out')


# --- a running node ---------------------------------------------------------------------------


def _of_node(args: argparse.Namespace, stop: StopSignals) -> int:
    with open_door(args.node, args.timeout) as door:
        after_seq = args.since_seq
        if args.last is not None:
            # A status tells of events a moment after they have happened.
            newest = door.events_after(door.status().seq, 1).last_seq
            after_seq = max(newest - args.last, 0)
        printer = _Printer(args.count)
        door.follow(printer, after_seq)
        quiet_at = time.monotonic() + QUIET_S
        while not stop.requested and printer.left != 0:
            if printer.is_quiet and time.monotonic() >= quiet_at:
                printer.is_quiet = False
                print(f'waiting for events of {door.name}; Ctrl-C ends', file=sys.stderr)
            door.turn(STEP_S)
    return 0


class _Printer(Ignoring):
    """Prints each event, as many as are wanted."""

    def __init__(self, count: int | None) -> None:
        self.left = count
        """None: all."""
        self.is_quiet = True
        """Nothing has come yet, and nothing was said of that."""

    def on_event(self, event: Event) -> None:
        """Print it."""
        if self.left != 0:
            self.is_quiet = False
            print(to_text(event), flush=True)
            self.left = None if self.left is None else self.left - 1

    def on_gap(self, first: int, last: int) -> None:
        """Say what will never be printed."""
        _say_removed(first, last)

    def on_history(self, history: str) -> None:
        """Say that the numbers begin anew."""
        what = f'the node has another journal (history {history}); from its beginning:'
        print(what, file=sys.stderr)


def _say_removed(first: int, last: int) -> None:
    print(removed(first, last), file=sys.stderr)


# --- a journal --------------------------------------------------------------------------------


def _of_journal(stop: StopSignals, args: argparse.Namespace) -> int:
    with closing(open_records(args.journal)) as records:
        reading = Reading(records, say_damage)
        with _output(args, reading) as write:
            for text in itertools.islice(_records(reading, args, stop), args.count):
                if stop.requested and not args.follow:
                    raise KeyboardInterrupt  # the rest may be long, and nobody waits for it
                write(with_cell(text, args))
        return 1 if reading.lost else 0


@contextmanager
def _output(args: argparse.Namespace, reading: Reading) -> Iterator[Callable[[str], None]]:
    """Give what takes one record after another.

    :raises WrongUse: it cannot be written
    """
    if args.format == PARQUET.name:
        with tables_in(args.output, reading) as write:
            yield write
        return
    made = _export(args.format or 'jsonl')
    with opened(args.output) as file:
        output = made(file)
        if isinstance(output, Timed):
            output.take_steps(steady_time(reading))

        def write_at_once(text: str) -> None:
            output.write(text)
            file.flush()

        yield write_at_once if args.follow else output.write
        output.close()


def _export(name: str) -> Callable[[IO[str]], Output]:
    return OUTPUTS.get(name) or of_others('exports')[name].load()


def _records(reading: Reading, args: argparse.Namespace, stop: StopSignals) -> Iterator[str]:
    """Yield the records that are there, and with --follow those that come."""
    stopped = threading.Event()
    stop.notify(stopped.set)
    wanted = Wanted(args.since_seq or 0, args.job, tuple(args.event or ()), args.since, args.until)
    if args.last is None:
        is_continued = args.since_seq is not None
    else:
        end = reading.records.extent().last_seq
        newest = replace(wanted, before_seq=end + 1, newest_first=True)
        last = list(reading.each(newest, args.last))
        yield from (record.text for record in reversed(last))
        if not args.follow:
            return
        wanted, is_continued = wanted.past(end), True
    ends_within = stopped.wait if args.follow else None
    for page in reading.pages(wanted, is_continued=is_continued, ends_within=ends_within):
        yield from (record.text for record in page.records)
        if page.is_last and (not args.follow or stopped.wait(POLL_S)):
            return


# The format `parquet` of the verb `events`: a folder with two tables, for BI tools.


@contextmanager
def tables_in(folder: Path | None, reading: Reading) -> Iterator[Callable[[str], None]]:
    """Give what takes one record after another; the tables are at their places at the end.

    :param reading: of the journal
    :raises WrongUse: no folder is named, it cannot be written, or pyarrow is missing
    """
    if folder is None:
        raise WrongUse('parquet is two tables in a folder; name it: -o FOLDER')
    PARQUET.demand()
    started = reading.events(Wanted(events=(OrchestratorStarted.event,)))
    starts = [event.seq for event in started]
    try:
        export = import_module(f'{PARQUET.room}.export').ParquetExport(
            folder, reading.records.extent().history, steady_time(reading), starts
        )
    except OSError as error:
        raise WrongUse(cannot_write(folder, error)) from error
    try:
        yield export.write
        export.close()
    except BaseException:
        export.discard()
        raise
