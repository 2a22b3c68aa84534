"""The file of users, for its owner alone: roles, hashes of passwords, keys; and users of now."""

from __future__ import annotations

import base64
import fcntl
import os
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
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
from bt_orchestrator.script.users.keys import DOOR_KINDS, Key, Keys, public_key
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
    keys: Keys = MappingProxyType({})


PROJECT = 'bt_orchestrator'


class NoHome(OrchestratorError):
    """The home folder of this user is not known, as in a container."""


def own_folder(environment: Mapping[str, str], variable: str, below: str) -> Path:
    """Return a folder of the user for files of this project, as the XDG base directories say.

    :param variable: which names the folder for files of all programs
    :param below: where that is in the home folder if the variable is not set
    :raises NoHome: it is not set, and there is no home folder
    """
    if environment.get(variable):
        return Path(environment[variable], PROJECT)
    try:
        return Path.home() / below / PROJECT
    except RuntimeError:
        raise NoHome(
            f'there is no home folder for user id {os.getuid()}, in which {below}/{PROJECT} would '
            f'be; set HOME or {variable}, or name the path with an option'
        ) from None


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
        """Return all users, panels and keys; nothing where there is no file.

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
        _check_name(name)
        user = User(role, hashed(password))

        def change(content: Content) -> Content:
            if name in content.users:
                raise NoSuchChange(f'{name} is there already; remove that user first')
            return content._replace(users={**content.users, name: user})

        self._change(change)

    def remove(self, name: str) -> None:
        """Remove a user and the key of that name, which are no panels any more either.

        Raises as `change_role` does.
        """

        def change(content: Content) -> Content:
            _found_any(content, name)
            left = {other: user for other, user in content.users.items() if other != name}
            panels = content.panels.without('user', name)
            return _without_key(Content(left, panels, content.keys), name)

        self._change(change)

    def add_key(self, name: str, key: Key) -> None:
        """Add a key that signs requests.

        :raises NoSuchChange: there is a key of this name, or the name of this key; or it is none
        :raises UsersUnusable: as `read`, or it cannot be written
        """
        _check_name(name)

        def change(content: Content) -> Content:
            of_that = [other for other, old in content.keys.items() if old.public == key.public]
            if name in content.keys or of_that:
                there = f'the key {of_that[0]}' if of_that else f'a key of {name}'
                raise NoSuchChange(f'{there} is there already; remove it first: user no-key')
            return content._replace(keys={**content.keys, name: key})

        self._change(change)

    def remove_key(self, name: str) -> None:
        """Remove a key; a user of the same name stays. Raises as `change_role` does."""

        def change(content: Content) -> Content:
            if name not in content.keys:
                raise NoSuchChange(_no_such('key', name, content.keys))
            return _without_key(content, name)

        self._change(change)

    def change_role(self, name: str, role: Role) -> None:
        """Give a user, and the key of that name, another role.

        :raises NoSuchChange: there is no such user and no such key
        :raises UsersUnusable: as `read`, or it cannot be written
        """

        def change(content: Content) -> Content:
            _found_any(content, name)
            users, keys = dict(content.users), dict(content.keys)
            if name in users:
                users[name] = replace(users[name], role=role)
            if name in keys:
                keys[name] = replace(keys[name], role=role)
            return content._replace(users=users, keys=keys)

        self._change(change)

    def change_panel(self, kind: str, name: str, *, named: bool) -> None:
        """Name a panel, or take its name out.

        :param kind: user, address, certificate or key
        :raises NoSuchChange: see `Panels.changed`; or there is no such user, or key of a person
        :raises UsersUnusable: as `content`, or it cannot be written
        """

        def change(content: Content) -> Content:
            if kind == 'user' and named and name not in content.users:
                raise NoSuchChange(_no_such('user', name, content.users))
            if kind == 'key' and named:
                _check_own_key(content.keys, name)
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


def _check_name(name: str) -> None:
    if not name or name != name.strip() or not name.isprintable() or len(name) > WHO:
        raise NoSuchChange(
            f'{name!r} is not a name; expected up to {WHO} printable characters, with no space '
            'before or after them'
        )


def _found_any(content: Content, name: str) -> None:
    if name not in content.users and name not in content.keys:
        raise NoSuchChange(_no_such('user', name, (*content.users, *content.keys)))


def _no_such(what: str, name: str, known: Iterable[str]) -> str:
    return f'there is no {what} {name}; there are: {", ".join(known) or "none"}'


def _check_own_key(keys: Keys, name: str) -> None:
    if name not in keys:
        raise NoSuchChange(_no_such('key', name, keys))
    if keys[name].door:
        raise NoSuchChange(
            f'the key {name} is of {DOOR_KINDS[keys[name].door].words}, which says itself who of '
            'its users is at a panel'
        )


def _without_key(content: Content, name: str) -> Content:
    keys = {other: key for other, key in content.keys.items() if other != name}
    return content._replace(keys=keys, panels=content.panels.without('key', name))


# --- as YAML ------------------------------------------------------------------------------------


def _plain(content: Content) -> dict[str, Any]:
    panels = {field: list(getattr(content.panels, field)) for field in PANEL_KINDS.values()}
    keys = {
        name: {'role': key.role.value, 'ed25519': key.public, 'door': key.door}
        for name, key in content.keys.items()
    }
    return {
        'format': FORMAT,
        'users': {
            name: {'role': user.role.value, 'password': _plain_hash(user.password)}
            for name, user in content.users.items()
        },
        **({'panels': panels} if content.panels else {}),
        **({'keys': keys} if keys else {}),
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
    keys = {_name(name): _key(fields) for name, fields in (plain.get('keys') or {}).items()}
    return Content(users, panels_of(plain.get('panels') or {}), keys)


def _name(name: Any) -> str:
    if not isinstance(name, str):
        raise TypeError(f'the name {name!r} is not a text')
    return name


def _key(fields: Any) -> Key:
    if not isinstance(fields, Mapping):
        raise TypeError('expected the keys role and ed25519 of each key')
    door, public = fields.get('door') or '', str(fields['ed25519'])
    if door and door not in DOOR_KINDS:
        raise ValueError(f'door {door!r}; expected {" or ".join(DOOR_KINDS)}')
    public_key(public)
    return Key(Role(fields['role']), public, door)


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
        self.path = path
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

    def keys(self) -> Keys:
        """Return all keys that sign requests.

        :raises UsersUnusable: the file cannot be believed or read
        """
        return self._now().keys

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
            status = self.path.stat()
        except OSError:
            return None
        return status.st_ino, status.st_mtime_ns, status.st_ctime_ns
