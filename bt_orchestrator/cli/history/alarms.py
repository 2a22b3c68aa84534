"""The verb `alarms`: what waited for people, when, and who did what about it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import IO

from bt_orchestrator.cli.here import add_journal_option
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.numbers import add_period_options
from bt_orchestrator.cli.output import opened
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.view.report.alarms import (
    Alarm,
    Kind,
    alarm_lines,
    alarm_plain,
    alarms_of,
    often,
    often_lines,
    write_alarms_csv,
)
from bt_orchestrator.view.report.reading import Reading

DESCRIPTION = """\
List the alarms of a journal, the last first: holds, aborts, contested components, state topics
without a publisher, and refused commands. Each has when it was raised, acknowledged, answered and
cleared, and by whom. The journal is only read; its node may run or not."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    add_journal_option(parser)
    parser.add_argument(
        '--kind',
        action='append',
        choices=[kind.value for kind in Kind],
        help='alarms of this kind only; may be repeated',
    )
    parser.add_argument('--component', metavar='COMPONENT', help='of this component only')
    parser.add_argument('--job', metavar='JOB', help='about this job only')
    parser.add_argument('--open', action='store_true', help='only those that stand')
    add_period_options(parser, 'alarms raised')
    form = parser.add_mutually_exclusive_group()
    form.add_argument(
        '--count',
        action='store_true',
        help='how often each came, and how long it stood, the most frequent first',
    )
    form.add_argument('--json', action='store_true', help='one JSON object an alarm and line')
    form.add_argument('--csv', action='store_true', help='as a table for a spreadsheet')
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE', help='where (default: the screen)'
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 if a record is damaged."""
    with closing(open_records(args.journal)) as records:
        reading = Reading(records, say_damage)
        fold = alarms_of(reading)
        first = records.extent().first_seq
    if first > 1:
        say_damage(f'events 1 to {first - 1} were removed from the journal, with their alarms')
    wanted = [alarm for alarm in fold.alarms if _is_wanted(alarm, args)]
    with opened(args.output) as file:
        _write(wanted, fold.now_us, args, file)
    return 1 if reading.lost else 0


def _is_wanted(alarm: Alarm, args: argparse.Namespace) -> bool:
    return (
        (args.kind is None or alarm.kind.value in args.kind)
        and args.component in (None, alarm.component)
        and args.job in (None, alarm.job)
        and not (args.open and alarm.cleared_us is not None)
        and (args.since is None or args.since <= alarm.raised_at)
        and (args.until is None or alarm.raised_at < args.until)
    )


def _write(alarms: list[Alarm], now_us: int, args: argparse.Namespace, file: IO[str]) -> None:
    if args.csv:
        write_alarms_csv(alarms, now_us, file)
        return
    if args.json:
        lines: Iterator[str] = (json_of(alarm_plain(alarm, now_us)) for alarm in alarms)
    elif args.count:
        lines = often_lines(often(alarms, now_us))
    elif alarms:
        lines = alarm_lines(alarms, now_us, None)
    else:
        lines = iter(['no alarms'])
    file.writelines(f'{line}\n' for line in lines)
