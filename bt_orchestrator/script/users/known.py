"""The users of now: the file is read again when it has changed."""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.script.users.file import User, Users, UsersFile, matching

_Version = tuple[int, int, int] | None


class KnownUsers:
    """Users by name: a removed user, or another role, counts at once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = UsersFile(path)
        self._version: _Version = None
        self._users: Users = {}

    def get(self, name: str) -> User | None:
        """Return a user; None: no user has that name.

        :raises UsersUnusable: the file cannot be believed or read
        """
        return self.all().get(name)

    def all(self) -> Users:
        """Return all users.

        :raises UsersUnusable: the file cannot be believed or read
        """
        version = self._look()
        if version is None or version != self._version:
            self._users = self._file.read()
            self._version = version
        return self._users

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
