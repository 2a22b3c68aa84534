"""The verb `request`: any request of the table by its name, or the list of all."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.command_parser import in_one_line
from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.ordering.order_request import give_orders
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.requests import REQUESTS, TABLE, Kind, Parameter, Request, Why
from bt_orchestrator.script.given_values import results_of

DESCRIPTION = """\
Make any request to the cell by its name, which is its subject and its word:

  request job.move job=WO-7 position=1 --reason 'the customer waits'
  request hold.mark_done hold=3 results.measurement=3.5 --reason 'measured by hand'
  request queue.add orders=first.yaml orders=second.yaml

Without a name: every request with its arguments and the roles that may make it."""

_FORMS: Mapping[Kind, str] = {
    Kind.TEXT: 'TEXT',
    Kind.WHOLE: 'N',
    Kind.YES_NO: 'yes|no',
    Kind.TEXTS: 'TEXT, may be repeated',
    Kind.VALUES: '{NAME: VALUE, ...}, or one value as in .NAME=VALUE',
    Kind.ORDERS: 'FILE, may be repeated',
}
"""How a value is written."""

_YES_NO = {'yes': True, 'true': True, 'no': False, 'false': False}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        'name', nargs='?', metavar='NAME', help='the request, as in job.move; none: list all'
    )
    parser.add_argument(
        'arguments', nargs='*', metavar='ARGUMENT=VALUE', help='what the request takes'
    )
    parser.add_argument('--json', action='store_true', help='print the answer as JSON')
    add_who_options(parser, required=False)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when the request was refused."""
    if args.name is None:
        print('\n'.join(line for request in TABLE for line in described(request)))
        return 0
    request = REQUESTS.get(args.name)
    if request is None:
        raise WrongUse(f'request: there is no request {args.name!r}; `request` alone lists all')
    if request.why is Why.FIRST and not args.reason:
        raise WrongUse(f'request {request.name}: say why, with --reason TEXT')
    given = arguments_from(request, args.arguments)
    if files := given.pop('orders', None):
        return give_orders(args, files, **given)
    return ask_and_print(args, request.name, as_json=args.json, **given)


def described(request: Request) -> Iterator[str]:
    """Yield a request and its arguments, a line each."""
    yield f'{request.name:<25}{in_one_line(request)}'
    for parameter in request.parameters:
        needed = ' (required)' if parameter.is_required else ''
        yield f'  {parameter.name}={_FORMS[parameter.kind]}: {parameter.meaning}{needed}'


def arguments_from(request: Request, words: Sequence[str]) -> dict[str, Any]:
    """Return the arguments of a request, by name.

    :param words: each as NAME=VALUE
    :raises WrongUse: says which word is wrong, and what was expected
    """
    known = {parameter.name: parameter for parameter in request.parameters}
    texts: dict[str, list[str]] = {}
    for word in words:
        name, equals, _ = word.partition('=')
        parameter = known.get(name.partition('.')[0])
        if not equals or parameter is None:
            expected = ', '.join(f'{name}=...' for name in known) or 'no arguments'
            raise WrongUse(f'request {request.name}: expected {expected}; found {word!r}')
        texts.setdefault(parameter.name, []).append(word)
    return {name: _value(request, known[name], given) for name, given in texts.items()}


def _value(request: Request, parameter: Parameter, words: Sequence[str]) -> Any:
    try:
        if parameter.kind is Kind.VALUES:
            return results_of(words)[parameter.name]
        values = [word.removeprefix(f'{parameter.name}=') for word in words]
        if parameter.kind in _SEVERAL:
            return _SEVERAL[parameter.kind](values)
        if len(values) > 1:
            raise ValueError(f'{parameter.name} is given twice')
        return _ONE[parameter.kind](values[0])
    except (KeyError, ValueError) as error:
        expected = f'{parameter.name}={_FORMS[parameter.kind]}'
        text = ' '.join(words)
        raise WrongUse(
            f'request {request.name}: expected {expected}; found {text!r} ({error})'
        ) from error


_ONE: Mapping[Kind, Callable[[str], Any]] = {
    Kind.TEXT: str,
    Kind.WHOLE: int,
    Kind.YES_NO: _YES_NO.__getitem__,
}

_SEVERAL: Mapping[Kind, Callable[[Sequence[str]], Any]] = {
    Kind.TEXTS: list,
    Kind.ORDERS: lambda files: [Path(file) for file in files],
}
