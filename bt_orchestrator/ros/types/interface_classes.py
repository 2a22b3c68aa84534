"""Finding the Python classes of installed actions and messages; needs no ROS context."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from functools import cache
from types import ModuleType
from typing import Any

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.script.report import did_you_mean, listing

_KINDS = {'action': 'an action', 'msg': 'a message', 'srv': 'a service'}


def action_class(name: str) -> Any:
    """Return the class of an action type such as pkg/action/Name.

    :raises UnknownActionType: it is not installed, or is no action type
    """
    return _find(name, 'action')


def message_class(name: str) -> Any:
    """Return the class of a message type such as pkg/msg/Name.

    :raises UnknownActionType: it is not installed, or is no message type
    """
    return _find(name, 'msg')


@cache
def _find(name: str, kind: str) -> Any:
    parts = name.split('/')
    example = f'package/{kind}/Name'
    if len(parts) != 3 or not all(part.isidentifier() for part in parts):
        what = f'{name!r} is not a type name'
        raise UnknownActionType(name, what, f'write it as {example}')
    package, found_kind, short = parts
    if found_kind != kind:
        what = f'{name} is {_KINDS.get(found_kind, "of no known kind")}, not {_KINDS[kind]}'
        raise UnknownActionType(name, what, f'name a type written {example}')
    module = _module(name, package, kind)
    interface = getattr(module, short, None)
    if interface is None or not _is_of(kind, interface):
        raise UnknownActionType(name, *_no_such(package, kind, short, module))
    return interface


def _module(name: str, package: str, kind: str) -> ModuleType:
    try:
        importlib.import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise _broken(name, package, error) from error
        what = f'the package {package} is not installed'
        hint = 'check its spelling, or install it and source its workspace'
        raise UnknownActionType(name, what, hint) from error
    except ImportError as error:
        raise _broken(name, package, error) from error
    try:
        return importlib.import_module(f'{package}.{kind}')
    except ModuleNotFoundError as error:
        if error.name != f'{package}.{kind}':
            raise _broken(name, package, error) from error
        what = f'the package {package} has no {kind} types'
        raise UnknownActionType(name, what, 'is the type in another package?') from error
    except ImportError as error:
        raise _broken(name, package, error) from error


def _broken(name: str, package: str, error: ImportError) -> UnknownActionType:
    what = f'the package {package} cannot be loaded: {error}'
    return UnknownActionType(name, what, 'build and source its workspace again')


def _no_such(package: str, kind: str, short: str, module: ModuleType) -> tuple[str, str]:
    what = f'the package {package} has no {kind} type {short}'
    other = {'action': 'msg', 'msg': 'action'}[kind]
    try:
        elsewhere = importlib.import_module(f'{package}.{other}')
    except ImportError:
        elsewhere = module
    if elsewhere is not module and _is_of(other, getattr(elsewhere, short, None)):
        return f'{package}/{other}/{short} is {_KINDS[other]}, not {_KINDS[kind]}', (
            f'its {kind} types are {listing(_names(kind, module))}'
        )
    known = list(_names(kind, module))
    return what, did_you_mean(short, known, f'it has {listing(known)}')


def _names(kind: str, module: ModuleType) -> Iterator[str]:
    return (name for name, member in sorted(vars(module).items()) if _is_of(kind, member))


def _is_of(kind: str, member: object) -> bool:
    """Tell actions and messages from what else such a module holds, by what rosidl generates."""
    if kind == 'action':
        return hasattr(member, 'Goal') and hasattr(member, 'Result')
    return hasattr(member, 'SLOT_TYPES')
