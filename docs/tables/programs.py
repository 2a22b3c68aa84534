"""The verbs of the program with their options, and the parameters of the node."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from bt_orchestrator.cli.verbs import (
    GROUPS,
    PROGRAM,
    VERBS,
    actions_of,
    command_of,
    help_line,
)
from bt_orchestrator.ros.node_parameters import MOST_JOBS, NodeParameters, Words, described
from tables.markdown import cell, table


def verbs() -> Iterator[str]:
    """Yield the table of all verbs, by what a person wants to do."""
    rows = (
        (wanted if number == 0 else '', f'`{name}`', cell(help_line(name)))
        for wanted, group in GROUPS.items()
        for number, name in enumerate(group)
    )
    yield from table(('to', 'verb', 'does'), rows)


def options_of_the_verbs() -> Iterator[str]:
    """Yield what every verb takes."""
    for verb in VERBS:
        for name in actions_of(verb) or ('',):
            words = [verb, name] if name else [verb]
            line = actions_of(verb)[name].effect if name else help_line(verb)
            yield f'## `{PROGRAM} {" ".join(words)}`'
            yield ''
            yield f'{line[0].upper()}{line[1:]}.'
            yield ''
            yield from table(('argument', 'meaning'), map(_argument, _declared(words)))


def parameters_of_the_node() -> Iterator[str]:
    """Yield the parameters of the tree node."""
    yield from table(
        ('parameter', 'default', 'meaning'), (_parameter(*one) for one in described())
    )


def _argument(action: argparse.Action) -> tuple[str, str]:
    words = ', '.join(action.option_strings) or _metavar(action)
    value = f' {_metavar(action)}' if action.option_strings and action.nargs != 0 else ''
    needed = ' **(required)**' if action.required and action.option_strings else ''
    text = (action.help or '') % {**vars(action), 'prog': PROGRAM}
    return f'`{cell(words + value)}`', f'{cell(text)}{needed}'


def _declared(words: list[str]) -> list[argparse.Action]:
    """Return what a verb or an action of it declares, groups included."""
    parser = argparse.ArgumentParser(add_help=False)
    command_of(words).action.add_arguments(parser)
    return parser._actions  # noqa: SLF001 - argparse has no other list of them


def _metavar(action: argparse.Action) -> str:
    if action.choices is not None and not isinstance(action.metavar, str):
        return '|'.join(map(str, action.choices))
    name = str(action.metavar or action.dest.upper())
    return f'{name}...' if action.nargs in ('+', '*') else name


def _parameter(name: str, words: Words) -> tuple[str, str, str]:
    default = getattr(NodeParameters(), name)
    shown = str(default).lower() if isinstance(default, bool) else str(default or '')
    meaning = words.meaning
    if words.choices:
        meaning = f'{" or ".join(f"`{choice}`" for choice in words.choices)}; {meaning}'
    elif words.low is not None and words.high != MOST_JOBS:
        meaning += f'; {words.low:g} to {words.high:g}'
    return f'`{name}`', f'`{shown}`' if shown else '', cell(meaning)
