"""argparse that says what was probably meant, what it parses for, and help of requests."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, NoReturn

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.requests import Request, Why
from bt_orchestrator.script.report import nearest

# The arguments and the work of a verb, or of an action of a group of verbs.


class Action(NamedTuple):
    """One thing that can be typed, as `status`, or `pause` of `cell`."""

    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]
    """Carries it out; returns the exit status."""
    effect: str = ''
    """One line of help."""


# argparse that says what was probably meant.


class CommandParser(argparse.ArgumentParser):
    """A parser whose mistakes name the option or the word that is most like the one found."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{'allow_abbrev': False, **settings})

    def error(self, message: str) -> NoReturn:
        """Print how it is used, the mistake, and what was probably meant; end with 2."""
        match = re.match(r'unrecognized arguments: (--?[\w-]+)', message)
        hint = meant(match[1], self._option_string_actions) if match else ''
        super().error(f'{message}{hint}')

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            known = [str(choice) for choice in action.choices]
            what = f'expected one of {", ".join(known)}; found {value!r}'
            raise argparse.ArgumentError(action, what + meant(str(value), known))


def meant(word: str, known: Iterable[str]) -> str:
    """Return the end of a sentence about a word that is not known; empty: none is like it."""
    near = nearest(word, known)
    return f'; did you mean {near}?' if near else ''


# Help of a request, from its declaration.


def in_one_line(request: Request) -> str:
    """Return what a request does, and who may ask for it."""
    return f'{request.effect} ({allowed(request)})'


def allowed(request: Request) -> str:
    """Return who may ask for a request, in words."""
    return ', '.join(role.value for role in Role if role in request.roles)


def what_to_know(request: Request) -> str:
    """Return what a user should know before the request."""
    reason = {
        Why.FIRST: 'It needs a reason.',
        Why.AFTERWARDS: 'It does not wait for a reason; without one it is on record as empty.',
        Why.NEVER: '',
    }[request.why]
    final = 'It cannot be taken back.' if request.is_confirmed else ''
    effect = f'{request.effect[0].upper()}{request.effect[1:]}.'
    sentences = (effect, f'For: {allowed(request)}.', reason, final)
    return ' '.join(filter(None, sentences))
