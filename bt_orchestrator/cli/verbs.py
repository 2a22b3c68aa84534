"""The verbs of the program, and what a command line of theirs means."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from types import ModuleType
from typing import NamedTuple, cast

from bt_orchestrator.base.extending import EXTENSIONS, Extension, of_others
from bt_orchestrator.cli.command_parser import Action, CommandParser, in_one_line
from bt_orchestrator.model.requests import (
    TABLE,
    About,
    Request,
    words_about,
)

PROGRAM = 'bt-orchestrator'

GROUPS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    'set up a cell and its products': {
        'new-cell': ('new_cell', "write the first cell file, script and order of one's own cell"),
        'check': ('check', 'name every mistake of scripts and their cell, with places and hints'),
        'generate': ('generating.verb', 'write the script of a recipe for a cell'),
        'render': ('render', 'draw a script for review: SVG, PNG or PDF'),
        'simulate': (
            'simulating.verb',
            'run work orders in virtual time and print the prediction',
        ),
        'release-script': ('asked.derived', ''),
    },
    'run the cell': {
        'demo': (
            'demo.verb',
            'run a simulated cell, its node and an order, with a live view',
        ),
        'sim-cell': ('sim_cell', 'serve each component as a simulated ROS 2 action server'),
        'run': ('run', 'run the tree node of a cell: it takes orders and carries them out'),
        'page': ('verb', 'serve the operator page of a node, for any browser'),
        'opcua': ('verb', 'serve a node over OPC UA, for an MES or a SCADA'),
    },
    'give it work': {
        'submit': ('submit', 'give work orders to a node'),
        'queue': (
            'queue',
            'list the jobs of a node, add work orders, or propose an order of them',
        ),
        'job': (
            'asked.job',
            'change, hold or end one job: move, update, hold, pause, stop, abort',
        ),
        'what-if': ('what_if', 'say when jobs would end after some requests, and request nothing'),
    },
    'see what it does': {
        'status': ('status', 'print how a cell stands'),
        'watch': ('watch', 'show a node on the terminal, as it changes'),
        'events': ('events', 'print the events of a node as they come, or those of a journal'),
    },
    'decide': {
        'answer': ('answer', 'answer a hold: a task that failed, or whatever waits for a person'),
        'cell': (
            'asked.cell_verb',
            (
                'command the cell: reset, start, pause, resume, stop, abort, clear, local, '
                'remote, manual, production, at-panel'
            ),
        ),
        'component': (
            'asked.component',
            'take a component out of service, or send it a goal in manual mode',
        ),
        'remove-item': ('asked.derived', ''),
        'classify': ('asked.derived', ''),
        'request': ('request', 'make any request to the cell by its name, or list all requests'),
    },
    'look back': {
        'history': ('history.verb', 'print the jobs of a journal, their items and their events'),
        'alarms': ('history.alarms', 'list what waited for people, and who did what about it'),
        'report': ('reporting.verb', 'account for a shift, a day or a job: output and lost time'),
        'journal': ('journals.verb', 'restore a backup of a journal'),
        'feed': ('verb', 'copy the journal of a cell into the database of the plant'),
    },
    'maintain': {
        'doctor': ('doctor', 'check this machine and the cell on it, and say what to do'),
        'user': ('user', 'manage the users of pages and OPC UA servers, and their roles'),
        'completion': ('completion', 'print what makes bash, zsh or fish complete command lines'),
    },
}
"""The aims of a person: module and one line of help of each verb.

The module of an extension is looked for in its room.
A module has `add_arguments` and `run`, or `ACTIONS` with those of each. A verb without a line of
help is a request of the table.
"""

VERBS: Mapping[str, tuple[str, str]] = {
    verb: about for group in GROUPS.values() for verb, about in group.items()
}

_MOVED: Mapping[tuple[str, ...], tuple[str, str]] = {
    **{(request.word,): ('cell', request.word) for request in TABLE if request.cause},
    **{(typed,): ('component', typed) for typed in ('out-of-service', 'in-service')},
    **{('queue', word): ('job', word) for word in words_about(About.JOB)},
    ('queue', 'stop-after'): ('cell', 'stop-after'),
}
"""Old forms, which still work, and the new ones."""

_HELP = ('-h', '--help')


class Command(NamedTuple):
    """The command of a command line, and its other words."""

    words: tuple[str, ...]
    """The verb, and its action if it has any."""
    action: Action
    rest: Sequence[str]
    typed: tuple[str, ...]
    """The typed words, if `words` replaces an old form; else the same."""

    @property
    def name(self) -> str:
        """As a person types it."""
        return ' '.join(self.words)

    def parser(self) -> CommandParser:
        """Return what reads the rest."""
        parser = CommandParser(prog=f'{PROGRAM} {self.name}')
        self.action.add_arguments(parser)
        return parser


def command_of(words: Sequence[str]) -> Command:
    """Return the command that a command line asks for.

    :param words: the first is a verb, or an old form of one
    :raises SystemExit: help for a group of actions was asked for, or its action is wrong
    """
    verb, *rest = words
    typed: tuple[str, ...] = (verb,)
    if verb in VERBS and (actions := actions_of(verb)):
        place = _place_of_action(rest, actions)
        default = getattr(module_of(verb), 'DEFAULT', '')
        for_help = [] if place is not None else [word for word in rest if word in _HELP]
        typed = (verb, default if place is None else rest[place])
        if for_help or (typed not in _MOVED and typed[1] not in actions):
            group = declare_actions(CommandParser(prog=f'{PROGRAM} {verb}'), verb)
            group.parse_args(for_help if place is None else rest[place:])
        rest = [word for at, word in enumerate(rest) if at != place]
    new = _MOVED.get(typed, typed)
    return Command(new, action_of(*new), rest, typed)


def action_of(verb: str, action: str = '') -> Action:
    """Return an action of a verb, or what a verb without actions takes and does."""
    if action:
        return actions_of(verb)[action]
    module = module_of(verb)
    if verb in VERBS and not VERBS[verb][1]:
        made: Action = module.of_request(_request(verb))
        return made
    return Action(module.add_arguments, module.run)


def is_verb(word: str | None) -> bool:
    """Tell whether a command line may begin with a word."""
    is_ours = word is None or word in VERBS or (word,) in _MOVED
    return word is not None and (is_ours or word in of_others('verbs'))


def actions_of(verb: str) -> Mapping[str, Action]:
    """Return the actions of a verb; empty: it has none."""
    return getattr(module_of(verb), 'ACTIONS', {})


def declare_actions(
    parser: CommandParser, verb: str, *, with_options: bool = False
) -> CommandParser:
    """Declare the actions of a verb, for help, mistakes and shells; returns the parser."""
    parser.description = module_of(verb).DESCRIPTION
    parser.epilog = f'{PROGRAM} {verb} ACTION --help says more about an action'
    actions = parser.add_subparsers(dest='command_parser', metavar='ACTION', required=True)
    for name, action in actions_of(verb).items():
        action_parser = actions.add_parser(name, help=action.effect.replace('%', '%%'))
        if with_options:
            action.add_arguments(action_parser)
    return parser


def _place_of_action(words: Sequence[str], actions: Mapping[str, Action]) -> int | None:
    """Return where the action stands; options may stand before it."""
    is_value = False
    with_value: set[str] = set()
    for place, word in enumerate(words):
        if not word.startswith('-') and not is_value:
            return place
        if not with_value and not is_value:
            with_value = _options_with_value(actions.values())
        is_value = word in with_value
    return None


def _options_with_value(actions: Iterable[Action]) -> set[str]:
    options = set()
    for action in (*actions, *actions_of('job').values()):  # old forms: queue --as ID requeue
        parser = CommandParser(add_help=False)
        action.add_arguments(parser)
        declared = parser._actions  # noqa: SLF001 - argparse has no other list of them
        options |= {
            name for option in declared if option.nargs != 0 for name in option.option_strings
        }
    return options


def help_line(verb: str) -> str:
    """Return what a verb does."""
    return VERBS[verb][1] or in_one_line(_request(verb))


def _request(verb: str) -> Request:
    return next(request for request in TABLE if request.word == verb.replace('-', '_'))


def module_of(verb: str) -> ModuleType:
    """Import a verb; the others are not, for they may need ROS 2, and time.

    :raises ExtensionMissing: it is that of an extension, which is not there
    """
    if (extension := _extension(verb)) is not None:
        extension.demand(with_packages=False)
    if verb not in VERBS:
        return cast('ModuleType', of_others('verbs')[verb].load())
    return importlib.import_module(module_name(verb))


def module_name(verb: str) -> str:
    """Return the module of a verb of this program."""
    extension = _extension(verb)
    room = 'bt_orchestrator.cli' if extension is None else extension.room
    return f'{room}.{VERBS[verb][0]}'


def _extension(verb: str) -> Extension | None:
    return next((extension for extension in EXTENSIONS if extension.verb == verb), None)
