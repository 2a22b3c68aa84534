"""A node's check of signatures with its own clock, and somebody who signs for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.script.users.keys import (
    Key,
    Place,
    Sealed,
    Signatures,
    SigningKey,
    opened,
    sealed,
)

NODE, HISTORY, BOOT = '/bt_orchestrator', 'h1', 'b1'


class SignedBench:
    """Keys of a node, and its check."""

    def __init__(self, folder: Path, recorded: Mapping[str, int] | None = None) -> None:
        self._folder = folder
        self.keys: dict[str, Key] = {}
        self.panels: tuple[str, ...] = ()
        self.here = Place(NODE, HISTORY, Uptime(BOOT, 1000.0))
        self.check = Signatures(
            lambda: self.keys,
            lambda: self.panels,
            lambda: self.here,
            {} if recorded is None else recorded,
        )

    def made(self, name: str, role: Role = Role.ENGINEER, door: str = '') -> SigningKey:
        """Make a key, and name it to the node."""
        key = SigningKey.made(self._folder / f'{name}.pem')
        self.keys[name] = Key(role, key.public, door)
        return key

    def later(self, seconds: float) -> None:
        """Let time pass at the node."""
        up = self.here.up
        self.here = self.here._replace(up=Uptime(up.boot, up.seconds + seconds))

    def request(self, key: SigningKey, by: By | None = None, **other: Any) -> Sealed:
        """Return a request for this node and moment, but for what is named."""
        by = by or By('Eve', 'over there', 'a test')
        request = sealed('cell.start', '{}', by, self.here, key.next_number())
        return replace(request, **other)

    def send(self, key: SigningKey, by: By | None = None, **other: Any) -> By:
        """Sign such a request and check it; raises as `Signatures.sender`."""
        return self.bring(*signed(key, self.request(key, by, **other)))

    def bring(self, text: str, public: str, signature: bytes) -> By:
        """Check what was signed before."""
        return self.check.sender(opened(text), text, public, signature)


def signed(key: SigningKey, request: Sealed) -> tuple[str, str, bytes]:
    """Return what goes over the wire."""
    return request.text, key.public, key.sign(request.text)


def user_of_door(role: Role, known: Known = Known.PAGE_LOGIN) -> By:
    """Return somebody who has logged in at a door."""
    return By('Ann', 'page', 'why', role, known)
