"""The verb `what-if`: when jobs would end after some requests, before anybody makes them."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import shlex
from collections.abc import Iterator, Sequence
from typing import NoReturn

from bt_orchestrator.base.errors import counted
from bt_orchestrator.cli.door import instead_of_a_door, open_door
from bt_orchestrator.cli.folders import (
    add_recipes_option,
    add_trees_option,
    recipe_folders,
    script_folders,
)
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.cli.processes.planning_process import PlanningProcess
from bt_orchestrator.cli.verbs import command_of, is_verb
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.ports import Consequence, ExpectedJob, JobChange
from bt_orchestrator.view.report.tables import table

DESCRIPTION = """\
Work out when the jobs of a running cell would end after some requests, with the engine itself in
virtual time. Nothing is asked of the cell, and the line does not notice. Each request is one word
of this command line, written as it would be typed, without a reason:

  what-if 'job next WO-7'
  what-if 'submit rush.yaml' 'job hold WO-3'
  what-if 'answer 3 skip'

New orders are read here, with the scripts of --trees or of the folder trees, and the recipes of
--recipes or of the folder recipes."""


_ASKS_NOTHING = 'what-if: a verb that only looks asks nothing of the cell'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = 'exit status: 0 worked out, 1 a request would be refused, 2 wrong use'
    parser.add_argument('--json', action='store_true', help='one JSON object')
    add_trees_option(parser)
    add_recipes_option(parser)
    add_node_options(parser)
    parser.add_argument(
        'requests', nargs='+', metavar='REQUEST', help='a verb with its words, in quotes'
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    requests = [asked for text in args.requests for asked in _asked(text)]
    with open_door(args.node, args.timeout) as door:
        moment = door.moment()
        left_out = max(0, door.queue(most=1).queued - QUEUE_SHOWN)
    folders = script_folders(args.trees), recipe_folders(args.recipes)
    planning = PlanningProcess(*folders, any_path=True)
    with contextlib.closing(planning):
        consequence = planning.what_if(moment, requests)
    if args.json:
        print(json.dumps({**_plain(consequence), 'left_out': left_out}))
    else:
        print('\n'.join(lines(consequence, left_out)))
    return 1 if consequence.refusals else 0


class _Collecting:
    """A door without a cell behind it: it notes the requests."""

    def __init__(self) -> None:
        self.asked: list[Asked] = []

    def __enter__(self) -> _Collecting:
        return self

    def __exit__(self, *exception: object) -> None:
        """Keep what was noted."""

    def ask(self, asked: Asked) -> Answer:
        """Note a request."""
        self.asked.append(asked)
        return Answer(True, '')

    def status(self) -> NoReturn:
        """Refuse a verb that only looks.

        :raises WrongUse: always
        """
        raise WrongUse(_ASKS_NOTHING)

    moment = status


def _asked(text: str) -> Sequence[Asked]:
    """Return what a verb would ask.

    :raises WrongUse: it asks nothing
    """
    from bt_orchestrator.cli.main import parsed

    try:
        words = shlex.split(text)
    except ValueError as error:
        raise WrongUse(f'what-if: {text!r}: {error}') from error
    if not words or not is_verb(words[0]):
        raise WrongUse(f'what-if: expected a verb with its words, found {text!r}')
    if '--reason' not in command_of(words).parser().format_usage():
        raise WrongUse(_ASKS_NOTHING)
    reason = [] if '--reason' in words else ['--reason', 'what if']
    args = parsed([*words, *reason])
    door = _Collecting()
    with instead_of_a_door(door), contextlib.redirect_stdout(io.StringIO()):
        args.carry_out(args)
    return door.asked


def lines(consequence: Consequence, left_out: int = 0) -> Iterator[str]:
    """Yield a prediction as text.

    :param left_out: how many jobs at the end of the queue are not in it
    """
    yield from table(('job', 'ends in', 'would end in', 'change'), list(_rows(consequence)))
    yield from (f'{job}: the end is unknown, {why}' for job, why in consequence.unknown.items())
    yield from (f'would be refused: {refusal}' for refusal in consequence.refusals)
    yield from consequence.notes
    if left_out:
        last = f'the last {counted(left_out, "job")} of the queue'
        yield f'without {last}; a request about one of them is refused here, and not by the node'


def _rows(consequence: Consequence) -> Iterator[tuple[str, ...]]:
    for change in consequence.changes:
        yield (
            change.job,
            _end(change.before, 'new'),
            _end(change.after, 'not at all'),
            _change(change),
        )


def _end(job: ExpectedJob | None, none: str) -> str:
    if job is None:
        return none
    return 'unknown' if job.ends_s is None else f'{job.ends_s:.1f} s'


def _change(job: JobChange) -> str:
    if job.by_s is None:
        return '-'
    return '=' if job.change == 'same' else f'{job.by_s:+.1f} s'


def _plain(consequence: Consequence) -> dict[str, object]:
    """Return what JSON can carry."""
    return {
        'before': [job._asdict() for job in consequence.before],
        'after': [job._asdict() for job in consequence.after],
        'refusals': list(consequence.refusals),
        'unknown': dict(consequence.unknown),
        'notes': list(consequence.notes),
    }
