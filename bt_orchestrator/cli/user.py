"""The verb `user`: who may log in at pages and OPC UA servers, and whose key signs requests."""

from __future__ import annotations

import argparse
import getpass
import json
import os
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import UsersFile, default_file
from bt_orchestrator.script.users.keys import DOOR_KINDS, Key, SigningKey, public_key
from bt_orchestrator.script.users.panels import PANEL_KINDS
from bt_orchestrator.script.users.passwords import BadPassword, check

DESCRIPTION = """\
Users of pages and OPC UA servers, each with a role (docs/security.md). Passwords are asked for on
the terminal, twice; where there is none, one line of the standard input is the password.

  user list                  names and roles
  user add NAME --role ROLE  add a user
  user role NAME ROLE        give a user another role
  user remove NAME           remove a user, and the key of that name
  user key NAME --role ROLE  make a key that signs requests over ROS
  user no-key NAME           remove a key; a user of that name stays
  user panel KIND NAME       name a panel of the line: KIND is user, address, certificate or key
  user no-panel KIND NAME    take that back

A key is of a person. With --door it is of a page or an OPC UA server, which asserts the names and
roles of its users. The private key goes into a file for its owner alone (--file), the public key
into the file of users, which the node reads. With --public it was made on another computer.

While a line is in local, its panels alone may move it (docs/local.md). A panel is a user, every
user at an IP address, the OPC UA client with a certificate, by its thumbprint, or a key."""

EPILOG = """\
exit status: 0 done, 1 refused (the file is as it was), 2 wrong use"""

_ROLES = tuple(role.value for role in Role)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('action', choices=tuple(_ACTIONS), help='what to do')
    parser.add_argument(
        'what', nargs='*', metavar='WHAT', help='a user; role: a role too; panel: a kind before it'
    )
    parser.add_argument('--role', choices=_ROLES, help='add, key: what the user may do')
    parser.add_argument(
        '--door',
        choices=tuple(DOOR_KINDS),
        help='key: it is of a page or an OPC UA server, whose users have this role at most',
    )
    parser.add_argument(
        '--file',
        type=Path,
        metavar='FILE',
        help='key: where the private key goes (default: keys/NAME.pem beside the file of users)',
    )
    parser.add_argument(
        '--public', metavar='KEY', help='key: add this public key, which was made elsewhere'
    )
    parser.add_argument(
        '--users',
        type=Path,
        metavar='FILE',
        help='file of users (default: ~/.config/bt_orchestrator/users.yaml)',
    )
    parser.add_argument('--json', action='store_true', help='list: one JSON object')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    args.users = args.users or default_file(os.environ)
    return _ACTIONS[args.action](args, UsersFile(args.users))


def _list(args: argparse.Namespace, users: UsersFile) -> int:
    _expect(args, 0, 'nothing')
    content = users.content()
    roles = {name: user.role.value for name, user in content.users.items()}
    if args.json:
        entries = [{'name': name, 'role': role} for name, role in roles.items()]
        panels = [{'kind': kind, 'name': name} for kind, name in content.panels]
        keys = [
            {'name': name, 'role': key.role.value, 'door': key.door, 'public': key.public}
            for name, key in content.keys.items()
        ]
        print(json.dumps({'users': entries, 'panels': panels, 'keys': keys}))
        return 0
    width = max(map(len, roles), default=0)
    for name, role in roles.items():
        print(f'{name:<{width}}  {role}')
    if not roles:
        print('there are no users')
    if content.panels:
        print(f'panels: {content.panels.words}')
    for name, key in content.keys.items():
        door = f', of {DOOR_KINDS[key.door].words}' if key.door else ''
        print(f'key {name}: {key.role.value}{door}, {key.public}')
    return 0


def _add(args: argparse.Namespace, users: UsersFile) -> int:
    (name,) = _expect(args, 1, 'one name')
    if args.role is None:
        raise WrongUse(f'user add: --role is one of {", ".join(_ROLES)}')
    try:
        users.add(name, Role(args.role), _password(name))
    except BadPassword as error:
        raise WrongUse(f'user add: {error}') from error
    print(f'{name} has the role {args.role}')
    return 0


def _remove(args: argparse.Namespace, users: UsersFile) -> int:
    (name,) = _expect(args, 1, 'one name')
    users.remove(name)
    print(f'{name} is removed')
    return 0


def _key(args: argparse.Namespace, users: UsersFile) -> int:
    (name,) = _expect(args, 1, 'one name')
    if args.role is None:
        raise WrongUse(f'user key: --role is one of {", ".join(_ROLES)}')
    role, door = Role(args.role), args.door or ''
    if args.public is not None:
        try:
            public_key(args.public)
        except ValueError as error:
            raise WrongUse(f'user key: --public: {error}') from error
        users.add_key(name, Key(role, args.public, door))
        print(f'the key {name} has the role {args.role}')
        return 0
    path = args.file or _key_file(name, args.users)
    made = SigningKey.made(path)
    try:
        users.add_key(name, Key(role, made.public, door))
    except OrchestratorError:
        path.unlink()
        raise
    print(f'the key {name} has the role {args.role}; whoever has {path} is {name} to the node')
    print(f'its public key is {made.public}')
    return 0


def _key_file(name: str, users: Path) -> Path:
    if re.fullmatch(r'\w[\w.-]*', name, re.ASCII) is None:
        raise WrongUse(f'user key: {name!r} cannot be the name of a file; name one with --file')
    return users.parent / 'keys' / f'{name}.pem'


def _no_key(args: argparse.Namespace, users: UsersFile) -> int:
    (name,) = _expect(args, 1, 'one name')
    users.remove_key(name)
    print(f'the key {name} is removed')
    return 0


def _role(args: argparse.Namespace, users: UsersFile) -> int:
    name, role = _expect(args, 2, 'a name and a role')
    if role not in _ROLES:
        raise WrongUse(f'user role: a role is one of {", ".join(_ROLES)}; found {role!r}')
    users.change_role(name, Role(role))
    print(f'{name} has the role {role}')
    return 0


def _panel(args: argparse.Namespace, users: UsersFile) -> int:
    kind, name = _expect(args, 2, f'{" or ".join(PANEL_KINDS)}, and a name')
    if kind not in PANEL_KINDS:
        kinds = ', '.join(PANEL_KINDS)
        raise WrongUse(f'user {args.action}: a panel is one of {kinds}; found {kind!r}')
    named = args.action == 'panel'
    users.change_panel(kind, name, named=named)
    print(f'the {kind} {name} is {"a panel" if named else "no panel any more"}')
    return 0


_ACTIONS: Mapping[str, Callable[[argparse.Namespace, UsersFile], int]] = {
    'list': _list,
    'add': _add,
    'role': _role,
    'remove': _remove,
    'key': _key,
    'no-key': _no_key,
    'panel': _panel,
    'no-panel': _panel,
}


def _password(name: str) -> str:
    """Ask for a new password.

    :raises WrongUse: none came, or two that differ
    """
    if not sys.stdin.isatty():
        line = sys.stdin.readline()
        if not line:
            raise WrongUse('user add: no password came; give it as one line of the standard input')
        return line.rstrip('\r\n')
    try:
        first = getpass.getpass(f'password of {name}: ')
        check(first)  # before somebody types it again
        if getpass.getpass('the same again: ') != first:
            raise WrongUse('user add: the two passwords differ; nothing was changed')
    except EOFError:
        raise WrongUse('user add: no password came; nothing was changed') from None
    return first


def _expect(args: argparse.Namespace, count: int, what: str) -> list[str]:
    if len(args.what) != count:
        words = ' '.join(args.what) or 'nothing'
        raise WrongUse(f'user {args.action}: expected {what}, found {words}')
    return list(args.what)
