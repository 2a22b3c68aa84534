"""Measure what the orchestrator costs, against the targets of docs/performance.md."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path

import interrupts

from bench import (
    attached_rows,
    database_rows,
    engine_rows,
    opcua_rows,
    page_rows,
    reader_rows,
    report,
    report_rows,
    ros_rows,
    virtual_rows,
)
from bench.plot import draw
from bench.rows import TARGETS, Row, merged

Bench = Callable[[], Iterator[Row]]


def benches(args: argparse.Namespace) -> dict[tuple[str, ...], Bench]:
    """Return what measures which rows."""
    quick, rounds = args.quick, args.rounds or (1 if args.quick else 5)
    in_turns = args.rounds or (1 if quick else 10)
    tasks = args.tasks or (60 if quick else 10_000)
    events = args.events or (2_000 if quick else 1_000_000)
    return {
        ('simulator',): lambda: virtual_rows.simulator(rounds, 20 if quick else 500),
        ('engine', 'engine_against', 'engine_normal', 'engine_normal_against'): lambda: (
            engine_rows.engine(2 if quick else args.rounds or 40, 5 if quick else 30, args.against)
        ),
        ('sections',): lambda: virtual_rows.sections(rounds, 3 if quick else 60),
        ('queue',): lambda: virtual_rows.queue(rounds, 2 if quick else 40),
        ('check',): lambda: virtual_rows.check(*((1, 8, 4) if quick else (3, 200, 10))),
        ('pace',): lambda: virtual_rows.pace_row(rounds, 8 if quick else 100),
        ('recipe_pace', 'recipe_time'): lambda: virtual_rows.recipes(
            *((2, 20) if quick else (4 * rounds, 60))
        ),
        ('restart',): lambda: virtual_rows.restart(rounds, events),
        ('report',): lambda: report_rows.report(rounds, events),
        ('dispatch', 'dispatch_normal', 'polling', 'wrap', 'cpu', 'watcher'): lambda: (
            ros_rows.dispatch(in_turns, 3 if quick else 20)
        ),
        ('page_attached', 'opcua_attached', 'plain_client', 'plain_client_cpu'): lambda: (
            attached_rows.attached(in_turns, 3 if quick else 20)
        ),
        ('postgres_append',): lambda: database_rows.append(rounds, 5 if quick else 200),
        ('postgres_dispatch',): lambda: database_rows.dispatch(in_turns, 3 if quick else 20),
        ('own_part',): lambda: ros_rows.own_part(in_turns, 3 if quick else 20),
        ('readers', 'readers_cpu'): lambda: reader_rows.readers(
            rounds, *((3, 2_000) if quick else (20, 50_000))
        ),
        ('recipe_load',): lambda: ros_rows.planning(rounds, 3 if quick else 40),
        ('page_cpu', 'page_node', 'page_reader', 'page_readers'): lambda: page_rows.page(
            rounds, 3.0 if quick else 15.0
        ),
        ('opcua_order', 'opcua_node'): lambda: opcua_rows.opcua(rounds, 2 if quick else 20),
        ('setup_time', 'setup_memory'): lambda: ros_rows.setup(rounds),
        ('idle',): lambda: ros_rows.idle(rounds, 2.0 if quick else 8.0),
        ('drift_cpu', 'drift_memory'): lambda: ros_rows.drift(tasks),
    }


def main() -> int:
    """Run the benchmarks; 0 when every row holds its must."""
    args = _arguments()
    interrupts.heed()
    if args.merge:
        runs = [report.read(file) for file in args.merge]
        rows, about = merged([run for run, _ in runs]), [facts for _, facts in runs]
        print(*rows, sep='\n')
    else:
        machine = report.machine()
        print(machine, flush=True)
        rows = _measured(args)
        about = [
            {
                'date': time.strftime('%Y-%m-%d'),
                'command': shlex.join(['./scripts/bench', *sys.argv[1:]]),
                'machine': machine,
                'load': f'{os.getloadavg()[0]:.1f}',
            }
        ]
        print(f'load {os.getloadavg()[0]:.1f}')
    if args.json:
        report.write(args.json, rows, about[-1])
    if args.svg:
        args.svg.write_text(draw(rows))
    if args.page:
        report.put_on_page(args.page, rows, about, args.svg)
    missed = [row for row in rows if row.verdict == 'MISSED']
    return 1 if missed and not args.quick else 0


def _measured(args: argparse.Namespace) -> list[Row]:
    rows: list[Row] = []
    for keys, measure in benches(args).items():
        if args.only and not set(keys) & set(args.only):
            continue
        try:
            for row in measure():
                _show(row)
                rows.append(row)
        except Exception:
            # The other rows are worth having.
            print(f'no row of {", ".join(keys)}:', flush=True)
            traceback.print_exc()
            if args.quick:
                raise
    return rows


def _show(row: Row) -> None:
    print(row, flush=True)
    for name, value in row.notes.items():
        if isinstance(value, (int, float)):
            print(f'    {name}: {value:.4g}', flush=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='scripts/bench', description=__doc__)
    parser.add_argument('--quick', action='store_true', help='seconds a row, to see it work')
    parser.add_argument(
        '--only', action='append', choices=sorted(TARGETS), help='with what is measured beside it'
    )
    parser.add_argument(
        '--against', metavar='REV', help='revision whose engine takes turns with this one'
    )
    parser.add_argument('--rounds', type=int, help='default 5; latencies 10, engine 40')
    parser.add_argument('--tasks', type=int, help='of the drift (default 10000)')
    parser.add_argument('--events', type=int, help='of the journal (default 1000000)')
    parser.add_argument('--json', type=Path, metavar='FILE')
    parser.add_argument('--svg', type=Path, metavar='FILE', help='plot of latencies and growth')
    parser.add_argument('--page', type=Path, metavar='FILE', help='put the figures on that page')
    parser.add_argument(
        '--merge', type=Path, nargs='+', metavar='FILE', help='runs kept as JSON, instead of a new'
    )
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
