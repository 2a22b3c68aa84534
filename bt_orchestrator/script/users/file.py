"""The file of users, for its owner alone: names, roles, hashes of passwords; and users of now."""

from __future__ import annotations

import base64
import fcntl
import os
import stat
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import yaml

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.ordinary_file import open_ordinary, read_up_to
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.limits import WHO
from bt_orchestrator.script.users.folders import own_folder
from bt_orchestrator.script.users.panels import PANEL_KINDS, NoSuchChange, Panels, panels_of
from bt_orchestrator.script.users.passwords import NOBODYS, Cost, Hashed, hashed

FORMAT = 1
_HEAD = (
    '# Users of pages and OPC UA servers, written by `bt-orchestrator user`.\n'
    '# Passwords are kept as scrypt hashes.\n'
)
LARGEST_FILE = 4_000_000
"""Bytes; some 20,000 users."""
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


class UsersUnusable(OrchestratorError):
    """The file cannot be believed, read or written; says why and what to do."""


@dataclass(frozen=True)
class User:
    """Somebody who may log in."""

    role: Role
    password: Hashed


Users = Mapping[str, User]
"""By name."""


class Content(NamedTuple):
    """The content of the file."""

    users: Users = MappingProxyType({})
    panels: Panels = Panels()


def default_file(environment: Mapping[str, str]) -> Path:
    """Return where the file is unless somebody says otherwise."""
    return own_folder(environment, 'XDG_CONFIG_HOME', '.config') / 'users.yaml'


class UsersFile:
    """Users on the disk. Programs that change them wait for each other; readers never wait."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Users:
        """Return all users; raises as `content` does."""
        return self.content().users

    def content(self) -> Content:
        """Return all users and panels; nothing where there is no file.

        :raises UsersUnusable: it is damaged, or others may read or write it
        """
        try:
            with open_ordinary(self._path) as file:
                mode = os.fstat(file.fileno()).st_mode
                text = read_up_to(file, LARGEST_FILE)
        except FileNotFoundError:
            return Content()
        except OSError as error:
            raise UsersUnusable(_out_of_reach(self._path, error)) from error
        if mode & _OTHERS:
            raise UsersUnusable(
                f'{self._path}: other users of this computer may open it '
                f'(mode {mode & 0o777:o}), so it is not used; check that it has not been '
                'changed, then chmod 600 it'
            )
        try:
            return _content(yaml.safe_load(text))
        except (
            yaml.YAMLError,
            KeyError,
            TypeError,
            ValueError,
            RecursionError,
            NoSuchChange,
        ) as error:
            raise UsersUnusable(
                f'{self._path}: this is not a file of users, or it is damaged '
                f'({_in_short(error)}); bring a copy of it back, or remove it and add the users '
                'again'
            ) from error

    def verify(self, name: str, password: str) -> Role | None:
        """Return the role of a user; None: there is no such user, or the password is another one.

        :raises UsersUnusable: as `read`
        """
        user = matching(self.read(), name, password)
        return None if user is None else user.role

    def add(self, name: str, role: Role, password: str) -> None:
        """Add a user.

        :raises NoSuchChange: the name is taken, or is none
        :raises BadPassword: see `passwords`
        :raises UsersUnusable: as `read`, or it cannot be written
        """
        if not name or name != name.strip() or not name.isprintable() or len(name) > WHO:
            raise NoSuchChange(
                f'{name!r} is not a name; expected up to {WHO} printable characters, with no '
                'space before or after them'
            )
        user = User(role, hashed(password))

        def change(content: Content) -> Content:
            if name in content.users:
                raise NoSuchChange(f'{name} is there already; remove that user first')
            return content._replace(users={**content.users, name: user})

        self._change(change)

    def remove(self, name: str) -> None:
        """Remove a user, who is no panel any more either; raises as `change_role` does."""

        def change(content: Content) -> Content:
            _found(content.users, name)
            left = {one: user for one, user in content.users.items() if one != name}
            panels = content.panels
            named = tuple(one for one in panels.users if one != name)
            return Content(left, replace(panels, users=named))

        self._change(change)

    def change_role(self, name: str, role: Role) -> None:
        """Give a user another role.

        :raises NoSuchChange: there is no such user
        :raises UsersUnusable: as `read`, or it cannot be written
        """

        def change(content: Content) -> Content:
            user = replace(_found(content.users, name), role=role)
            return content._replace(users={**content.users, name: user})

        self._change(change)

    def change_panel(self, kind: str, name: str, *, named: bool) -> None:
        """Name a panel, or take its name out.

        :param kind: user, address or certificate
        :raises NoSuchChange: see `Panels.changed`; or there is no such user
        :raises UsersUnusable: as `content`, or it cannot be written
        """

        def change(content: Content) -> Content:
            if kind == 'user' and named:
                _found(content.users, name)
            return content._replace(panels=content.panels.changed(kind, name, named=named))

        self._change(change)

    def _change(self, change: Callable[[Content], Content]) -> None:
        if not self._path.name:
            raise UsersUnusable(f'{self._path}: Is a directory; name the file in it')
        try:
            with self._alone():
                content = change(self.content())
                self._write(_HEAD + yaml.safe_dump(_plain(content), sort_keys=False))
        except OSError as error:
            raise UsersUnusable(_out_of_reach(self._path, error)) from error

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Keep others from changing the file, which is another one after each change."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        lock = self._path.with_name(f'.{self._path.name}.lock')
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            yield
        finally:
            os.close(descriptor)

    def _write(self, text: str) -> None:
        """Replace the file as a whole: a reader, and a power cut, find the old one or the new."""
        folder = self._path.parent
        descriptor, name = tempfile.mkstemp(prefix=f'.{self._path.name}.', dir=folder)  # 0600
        try:
            with os.fdopen(descriptor, 'w', encoding='utf-8') as file:
                file.write(text)
                file.flush()
                os.fsync(descriptor)
            Path(name).replace(self._path)
        except BaseException:
            with suppress(OSError):
                Path(name).unlink()
            raise
        of_folder = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(of_folder)
        finally:
            os.close(of_folder)


def matching(users: Users, name: str, password: str) -> User | None:
    """Return the user with this name and password; None: there is none, found out as slowly."""
    user = users.get(name)
    matches = (user.password if user is not None else NOBODYS).matches(password)
    return user if matches else None


def _found(users: Users, name: str) -> User:
    if name not in users:
        raise NoSuchChange(f'there is no user {name}; there are: {", ".join(users) or "none"}')
    return users[name]


# --- as YAML ------------------------------------------------------------------------------------


def _plain(content: Content) -> dict[str, Any]:
    panels = {field: list(getattr(content.panels, field)) for field in PANEL_KINDS.values()}
    return {
        'format': FORMAT,
        'users': {
            name: {'role': user.role.value, 'password': _plain_hash(user.password)}
            for name, user in content.users.items()
        },
        **({'panels': panels} if content.panels else {}),
    }


def _plain_hash(password: Hashed) -> dict[str, Any]:
    return {
        'scrypt': vars(password.cost),
        'salt': base64.b64encode(password.salt).decode(),
        'hash': base64.b64encode(password.digest).decode(),
    }


def _content(plain: Any) -> Content:
    if not isinstance(plain, Mapping) or not isinstance(plain.get('users'), Mapping):
        raise TypeError('expected the keys format and users')
    if plain['format'] != FORMAT:
        raise ValueError(f'format {plain["format"]!r}; expected {FORMAT}')
    users = {_name(name): _user(fields) for name, fields in plain['users'].items()}
    return Content(users, panels_of(plain.get('panels') or {}))


def _name(name: Any) -> str:
    if not isinstance(name, str):
        raise TypeError(f'the name {name!r} is not a text')
    return name


def _user(fields: Any) -> User:
    if not isinstance(fields, Mapping):
        raise TypeError('expected the keys role and password of each user')
    password = fields['password']
    cost = Cost(**{name: int(value) for name, value in password['scrypt'].items()})
    if not cost.is_sane:
        raise ValueError(f'parameters of scrypt that cannot be: {password["scrypt"]}')
    salt = base64.b64decode(password['salt'], validate=True)
    digest = base64.b64decode(password['hash'], validate=True)
    return User(Role(fields['role']), Hashed(salt, digest, cost))


def _out_of_reach(path: Path, error: OSError) -> str:
    return f'{error.filename or path}: {error.strerror}; check its permissions'


def _in_short(error: Exception) -> str:
    words = f'no {error}' if isinstance(error, KeyError) else str(error)
    return words.splitlines()[0] if words else type(error).__name__


# The users of now: the file is read again when it has changed.

_Version = tuple[int, int, int] | None


class KnownUsers:
    """Users by name: a removed user, or another role, counts at once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = UsersFile(path)
        self._version: _Version = None
        self._content = Content()

    def get(self, name: str) -> User | None:
        """Return a user; None: no user has that name.

        :raises UsersUnusable: the file cannot be believed or read
        """
        return self.all().get(name)

    def all(self) -> Users:
        """Return all users.

        :raises UsersUnusable: the file cannot be believed or read
        """
        return self._now().users

    def panels(self) -> Panels:
        """Return all panels.

        :raises UsersUnusable: the file cannot be believed or read
        """
        return self._now().panels

    def _now(self) -> Content:
        version = self._look()
        if version is None or version != self._version:
            self._content = self._file.content()
            self._version = version
        return self._content

    def verify(self, name: str, password: str) -> User | None:
        """Return a user; None: no user has that name and password.

        It takes a fifth of a second of CPU, in any thread.

        :raises UsersUnusable: the file cannot be believed or read
        """
        return matching(self._file.read(), name, password)

    def _look(self) -> _Version:
        """Return what changes with the file: it is replaced as a whole. None: it is not there."""
        try:
            found = self._path.stat()
        except OSError:
            return None
        return found.st_ino, found.st_mtime_ns, found.st_ctime_ns
