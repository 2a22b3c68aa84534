"""The verb `component`: whether a component may get goals, and single goals in manual mode."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping

from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.asked.derived import actions_about, given, one_word
from bt_orchestrator.cli.command_parser import Action
from bt_orchestrator.cli.door import STEP_S, asked, open_door
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.requests import REQUESTS, About
from bt_orchestrator.model.status import CellStatus, ManualGoal
from bt_orchestrator.ports import CellLink
from bt_orchestrator.script.given_values import results_of

DESCRIPTION = """\
Take a component out of service, or bring it back. Out of service is no lockout: it does not
protect people at the machine. In manual mode, send it single goals (docs/local.md)."""

SIGN_OF_LIFE_S = 0.5
"""Time between two signs of life; the node cancels the goal after 2 s without one."""

_RUN = REQUESTS['component.run_task']
_VERB = one_word(_RUN.word)
_ALL = actions_about(About.COMPONENT)


def _add_run_task(parser: argparse.ArgumentParser) -> None:
    _ALL[_VERB].add_arguments(parser)
    parser.description = (
        f'{parser.description} It stays until the goal has ended, and tells the node that you are '
        'there. Ctrl-C cancels the goal. It returns 0 if the task was done.'
    )


def _run_task(args: argparse.Namespace) -> int:
    """Send a goal, and stay until it has ended; returns 1 if it was refused or not done."""
    try:
        fields = results_of(args.args or ())
    except ValueError as error:
        raise WrongUse(f'component run-task: {error}') from error
    wanted = given(_RUN, argparse.Namespace(**{**vars(args), 'args': fields or None}))
    with open_door(args.node, args.timeout) as door, StopSignals() as stop:
        before = door.status().manual
        answer = door.ask(asked(args, _RUN.name, **wanted))
        if not args.json or not answer.accepted:
            print(answer.message, file=sys.stdout if answer.accepted else sys.stderr, flush=True)
        if not answer.accepted:
            return 1
        goal = _until_it_ends(args, door, stop, before)
    print(json.dumps(_plain(goal)) if args.json else _words(goal), flush=True)
    return 0 if goal.state == 'done' else 1


def _until_it_ends(
    args: argparse.Namespace, door: CellLink, stop: StopSignals, before: ManualGoal | None
) -> ManualGoal:
    """Keep a goal running until it has ended, or cancel it after Ctrl-C."""
    next_s, is_cancelled = time.monotonic(), False
    while True:
        goal = _ended(door.status(), before)
        if goal is not None:
            return goal
        if stop.requested and not is_cancelled:
            is_cancelled = True
            print(door.ask(asked(args, 'component.cancel_task', component=args.component)).message)
        if time.monotonic() >= next_s:
            next_s += SIGN_OF_LIFE_S
            door.ask(asked(args, 'cell.at_panel'))
        door.turn(STEP_S)


def _ended(status: CellStatus, before: ManualGoal | None) -> ManualGoal | None:
    """Return the goal that came after another one, once it has ended."""
    goal = status.manual
    is_new = goal is not None and (before is None or goal.started > before.started)
    return goal if goal is not None and is_new and goal.ended is not None else None


def _words(goal: ManualGoal) -> str:
    results = f' {json.dumps(dict(goal.results))}' if goal.results else ''
    why = f' ({goal.message})' if goal.message else ''
    return f'{goal.task} at {goal.component}: {goal.state}{why}{results}'


def _plain(goal: ManualGoal) -> Mapping[str, object]:
    names = ('component', 'task', 'state', 'message', 'results', 'goal')
    return {name: vars(goal)[name] for name in names}


ACTIONS: Mapping[str, Action] = {
    **_ALL,
    _VERB: _ALL[_VERB]._replace(add_arguments=_add_run_task, run=_run_task),
}
