"""The option `--follow` of the verb `report`: the account of the shift that runs, as it grows."""

from __future__ import annotations

import argparse
import json
import select
import socket
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import replace
from datetime import datetime
from functools import partial

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.numbers import seconds
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.reporting.periods import with_reasons
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.script.shifts.shifts_file import read_shifts
from bt_orchestrator.view.report.account.calendar import Now, day_on, shift_at
from bt_orchestrator.view.report.account.live import Live, LiveAccount, live_line, live_plain
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.screen.keys import Keys, keys_of_person

EVERY_S, LEAST_S = 2.0, 0.2
"""Time between two looks: the usual one, and the shortest."""

_FAR_US = 10 * 366 * 24 * 3600 * 1_000_000
"""No end in sight: so long after the begin."""

_NO_USE = (
    'until',
    'job',
    'shift',
    'day',
    'days',
    'each_shift',
    'by',
    'html',
    'csv',
    'output',
    'durations',
    'update_durations',
)
_AS_TYPED = {'until': 'to'}


def add_follow_options(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        '--follow',
        action='store_true',
        help='go on until Ctrl-C, or q: of the shift that runs (with --shifts), or from --from or '
        'the begin of the day until now; on a terminal as a picture, else a line each time',
    )
    parser.add_argument(
        '--every',
        type=seconds,
        default=EVERY_S,
        metavar='SECONDS',
        help=f'with --follow: time between two looks (default {EVERY_S:g}); any key looks at once',
    )


def follow(args: argparse.Namespace, cell: Cell | None) -> int:
    """Show the account again and again; returns 1 if a record is damaged.

    :raises WrongUse: other options do not go with it
    :raises JournalUnusable: the journal cannot be read to begin with
    """
    _refuse_contradictions(args)
    with closing(open_records(args.journal)):
        pass  # a name that is wrong is said at once, and not on a picture
    with ExitStack() as stack:
        stop = stack.enter_context(StopSignals())
        picture = None if args.json else _picture(stack)
        account = LiveAccount(
            _period_with_reasons(args), cell, _nothing_said if picture is not None else say_damage
        )
        show = picture or (_print_json if args.json else _print_line)
        keys = None if picture is None else stack.enter_context(keys_of_person())
        waiting = stack.enter_context(StopOrKey(stop, keys))
        lost = 0
        while True:
            live, why_not = _look(account, args)
            show(live, why_not)
            lost = live.account.source.unreadable if live is not None else lost
            if waiting.ends_within(max(args.every, LEAST_S)):
                return 1 if lost else 0


class StopOrKey:
    """A context: waits for a stop signal, or for a key of the person, if there is one."""

    def __init__(self, stop: StopSignals, keys: Keys | None) -> None:
        self._stop = stop
        self._keys = keys

    def __enter__(self) -> StopOrKey:
        self._woken, self._wake = socket.socketpair()
        self._stop.notify(lambda: self._wake.send(b'.'))
        return self

    def __exit__(self, *exception: object) -> None:
        self._stop.notify(lambda: None)
        self._wake.close()
        self._woken.close()

    def ends_within(self, limit_s: float) -> bool:
        """Wait so long, or until a key is pressed; return whether the person wants an end."""
        inputs: list[socket.socket | Keys] = [self._woken]
        if self._keys is not None:
            inputs.append(self._keys)
        select.select(inputs, [], [], limit_s)
        keys = '' if self._keys is None else self._keys.pressed()
        return self._stop.requested or 'q' in keys


def _refuse_contradictions(args: argparse.Namespace) -> None:
    for name in _NO_USE:
        if getattr(args, name):
            option = _AS_TYPED.get(name, name.replace('_', '-'))
            raise WrongUse(f'--follow shows what goes on until now; leave --{option} out')
    if args.shifts is not None and args.since is not None:
        raise WrongUse('--follow shows the shift that runs; leave --from out, or --shifts')


def _period_with_reasons(args: argparse.Namespace) -> Callable[[float], Now]:
    period_at, plain = _period_at(args), Period.all_planned('', 0, 0)
    reasons = with_reasons(args, plain).reasons

    def period(now: float) -> Now:
        period_now = period_at(now)
        return period_now._replace(period=replace(period_now.period, reasons=reasons))

    return period


def _period_at(args: argparse.Namespace) -> Callable[[float], Now]:
    if args.shifts is not None:
        return partial(shift_at, read_shifts(args.shifts))
    if args.since is not None:
        begin = us_of(args.since)
        whole = Period.all_planned('period', begin, begin + _FAR_US)
        return lambda _: Now(whole)
    return lambda now: Now(day_on(datetime.fromtimestamp(now).date(), None))


def _look(account: LiveAccount, args: argparse.Namespace) -> tuple[Live | None, str]:
    """Return what there is, and why there is nothing of now."""
    try:
        with closing(open_records(args.journal)) as records:
            return account.look(records, time.time()), ''
    except JournalUnusable as error:
        return None, str(error)


# --- how it is shown --------------------------------------------------------------------------

Show = Callable[[Live | None, str], None]


def _picture(stack: ExitStack) -> Show | None:
    """Take the terminal, if the standard output is one."""
    from bt_orchestrator.view.screen.keys import second_screen
    from bt_orchestrator.view.screen.shift import ShiftScreen

    screen = stack.enter_context(second_screen())
    return None if screen is None else ShiftScreen(screen).show


def _print_line(live: Live | None, why_not: str) -> None:
    print(live_line(live) if live is not None else _missing(why_not), flush=True)


def _print_json(live: Live | None, why_not: str) -> None:
    plain = {'message': _missing(why_not)} if live is None else live_plain(live)
    print(json.dumps(plain, ensure_ascii=False), flush=True)


def _missing(why_not: str) -> str:
    return why_not or 'the journal has no event yet'


def _nothing_said(_: str) -> None:
    """Leave the picture unchanged: it says itself how many records are damaged."""
