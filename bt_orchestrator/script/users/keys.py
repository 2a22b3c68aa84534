"""Keys that sign requests over ROS, and the check of what they have signed (semantics 7.12)."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import stat
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bt_orchestrator.base.errors import CommandRefused, OrchestratorError
from bt_orchestrator.base.ordinary_file import open_ordinary, read_up_to
from bt_orchestrator.model.by import By, Known, Role, Signed
from bt_orchestrator.model.limits import NAME, REQUEST_BYTES, cut
from bt_orchestrator.model.texts import readable
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.model.words import sentence

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

FRESH_S = 10.0
"""Oldest request that is carried out, by the uptime of the node: a delayed start is an attack."""

ROUNDED_S = 0.01
"""A status has uptimes in milliseconds."""

SIZE = 32
"""Bytes of a public key."""

LARGEST_NUMBER = 2**53 - 1
"""Every JSON reader has whole numbers up to it."""

_PURPOSE = b'bt_orchestrator request 1\0'
"""Precedes what is signed: no signature made for anything else can be taken for a request's."""

_LARGEST_FILE = 10_000
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


class KeyUnusable(OrchestratorError):
    """A key file cannot be used, or the library for keys is missing; says what to do."""


class DoorKind(NamedTuple):
    """A kind of programs that people log in at; a key of one may assert no other one's users."""

    words: str
    known: Known
    """How such a program knows its users."""


DOOR_KINDS: Mapping[str, DoorKind] = {
    'page': DoorKind('a page', Known.PAGE_LOGIN),
    'opcua': DoorKind('an OPC UA server', Known.OPC_UA_USER),
}


@dataclass(frozen=True)
class Key:
    """A key that may sign requests, as the file of users has it."""

    role: Role
    """Of its requests; of a door: the highest that it may assert for its users."""
    public: str
    """Base64."""
    door: str = ''
    """One of `DOOR_KINDS`; empty: the key is of a person or a program of its own."""


Keys = Mapping[str, Key]
"""By name."""


def demand_library() -> None:
    """Refuse to go on without the library that signs and checks.

    :raises KeyUnusable: it is not installed; says how to get it
    """
    try:
        import cryptography.hazmat.primitives.asymmetric.ed25519  # noqa: F401
    except ImportError:
        raise KeyUnusable(
            'keys need the Python package cryptography, which cannot be imported; install it: '
            "pip install 'bt_orchestrator[signed]', or on Ubuntu: apt install python3-cryptography"
        ) from None


def public_key(text: str) -> bytes:
    """Return the bytes of a public key.

    :raises ValueError: it is none; says what was expected
    """
    try:
        key = base64.b64decode(text, validate=True)
    except ValueError:
        key = b''
    if len(key) != SIZE:
        raise ValueError(f'a public key has {SIZE} bytes, as base64; found {text!r:.60}')
    return key


class SigningKey:
    """A private key in a file, which is for its owner alone."""

    def __init__(self, path: Path) -> None:
        """Read the file.

        :raises KeyUnusable: it cannot be read, others may read it, or it has no such key
        """
        demand_library()
        self._path = path
        self._key = _read_private(path)
        self.public = _public(self._key)
        """Base64."""
        self._last = 0

    @classmethod
    def made(cls, path: Path) -> SigningKey:
        """Make a new key and its file.

        :raises KeyUnusable: the file is there already, or cannot be written
        """
        demand_library()
        from cryptography.hazmat.primitives import serialization as form
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

        pem = Ed25519PrivateKey.generate().private_bytes(
            form.Encoding.PEM, form.PrivateFormat.PKCS8, form.NoEncryption()
        )
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
            with os.fdopen(descriptor, 'wb') as file:
                file.write(pem)
                file.flush()
                os.fsync(descriptor)
        except FileExistsError:
            raise KeyUnusable(
                f'{path} is there already; remove it if nothing signs with it, or name another '
                'file with --file'
            ) from None
        except OSError as error:
            raise KeyUnusable(f'{path}: {error.strerror}; check its permissions') from error
        return cls(path)

    def sign(self, text: str) -> bytes:
        """Return the signature of the text of a request."""
        return self._key.sign(_PURPOSE + text.encode())

    def next_number(self) -> int:
        """Return a number that is higher than all before, of every program with this file.

        It is the time in microseconds, or one more than the last one, which stands in a file
        beside the key: the clock may have been set back. Where that cannot be written, the clock
        alone counts.
        """
        number = max(self._last + 1, time.time_ns() // 1000)
        with suppress(OSError, ValueError):
            beside = self._path.with_name(f'{self._path.name}.number')
            descriptor = os.open(beside, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            with os.fdopen(descriptor, 'r+') as file:
                fcntl.flock(file, fcntl.LOCK_EX)
                number = max(number, int(file.read(20) or 0) + 1)
                file.seek(0)
                file.write(f'{number}')
                file.truncate()
        self._last = number
        return number


def _read_private(path: Path) -> Ed25519PrivateKey:
    from cryptography.exceptions import UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        with open_ordinary(path) as file:
            mode = os.fstat(file.fileno()).st_mode
            text = read_up_to(file, _LARGEST_FILE)
    except FileNotFoundError:
        raise KeyUnusable(
            f'there is no key {path}; make one with: bt-orchestrator user key NAME --role ROLE'
        ) from None
    except OSError as error:
        raise KeyUnusable(f'{path}: {error.strerror}; check its permissions') from error
    if mode & _OTHERS:
        raise KeyUnusable(
            f'{path}: other users of this computer may open this key (mode {mode & 0o777:o}), so '
            'it is not used; make a new one, since they may have read it'
        )
    key: object = None
    with suppress(ValueError, TypeError, UnsupportedAlgorithm):
        key = load_pem_private_key(text, None)
    if not isinstance(key, Ed25519PrivateKey):
        raise KeyUnusable(
            f'{path}: expected a private ed25519 key as PEM without a password, as made by '
            '`bt-orchestrator user key`; found none'
        )
    return key


def _public(key: Ed25519PrivateKey) -> str:
    return base64.b64encode(key.public_key().public_bytes_raw()).decode()


# What is signed.


class Place(NamedTuple):
    """The node that a request is for, and the moment, as its status told them."""

    node: str
    """Its full name."""
    history: str
    up: Uptime


@dataclass(frozen=True)
class Sealed:
    """The signed form of a request: a change of any part spoils the signature."""

    name: str
    arguments: str
    """JSON or YAML."""
    who: str
    origin: str
    reason: str
    role: str
    """Role that a door asserts for its user; empty: none."""
    known: str
    """How the door knows the user; empty: the key itself asks."""
    node: str
    history: str
    boot: str
    uptime: float
    number: int

    @property
    def text(self) -> str:
        """The text that is signed."""
        return json.dumps(asdict(self), ensure_ascii=False)


def sealed(name: str, arguments: str, by: By, place: Place, number: int) -> Sealed:
    """Return the form of a request that is signed."""
    is_door = by.known.is_door
    role, known = (by.role.value, by.known.value) if is_door else ('', '')
    sender = (by.who, by.origin, by.reason, role, known)
    return Sealed(name, arguments, *sender, place.node, place.history, *place.up, number)


_KINDS: Mapping[str, Any] = {'str': str, 'float': (int, float), 'int': int}


def opened(text: str) -> Sealed:
    """Return a request of its text; nothing is checked but its form.

    :raises CommandRefused: it has another form
    """
    expected = ', '.join(field.name for field in fields(Sealed))
    if len(text) > 3 * REQUEST_BYTES:  # of which JSON in JSON makes more
        raise CommandRefused(sentence('signed_long', count=len(text)))
    try:
        plain: Any = json.loads(text)
        json.dumps(plain, ensure_ascii=False).encode()  # half a character would end the process
    except (ValueError, RecursionError):
        plain = None
    is_whole = isinstance(plain, dict) and plain.keys() == {field.name for field in fields(Sealed)}
    if not is_whole or not all(
        isinstance(plain[field.name], _KINDS[str(field.type)])
        and not isinstance(plain[field.name], bool)
        for field in fields(Sealed)
    ):
        raise CommandRefused(sentence('signed_form', fields=expected, found=f'{text!r:.60}'))
    return Sealed(**plain)


# The check, in the node.


class Signatures:
    """Checks signed requests: who has signed them, for which node, when, and only once."""

    def __init__(
        self,
        keys: Callable[[], Keys],
        panels: Callable[[], tuple[str, ...]],
        here: Callable[[], Place],
        recorded: Mapping[str, int],
    ) -> None:
        """Check for a node.

        :param keys: those of now
        :param panels: names of the keys that are panels of the line
        :param recorded: the last number of each key that is on record, by its public part
        """
        self._keys = keys
        self._panels = panels
        self._here = here
        self._recorded = recorded
        self._used: dict[str, int] = {}
        """Numbers that are not on record yet, or cannot be since the journal has failed."""

    def sender(self, request: Sealed, text: str, public: str, signature: bytes) -> By:
        """Return who has signed a request; its number is used from now on.

        :param text: of the request, as it came
        :raises CommandRefused: it does not count; says why and what to do
        :raises OrchestratorError: keys cannot be read or checked
        """
        name, key = self._key(public)
        if not _fits(public, text, signature):
            raise CommandRefused(sentence('signed_otherwise', key=name))
        here = self._here()
        for what, given, is_so in (
            ('node', request.node, here.node),
            ('journal', request.history, here.history),
        ):
            if given != is_so:
                names = {'found': f'{given!r:.80}', 'name': repr(is_so)}
                raise CommandRefused(sentence(f'signed_for_{what}', **names))
        last = max(self._recorded.get(public, 0), self._used.get(public, 0))
        if not last < request.number <= LARGEST_NUMBER:
            numbers = {'number': request.number, 'last': last}
            raise CommandRefused(sentence('signed_again', key=name, **numbers))
        self._used[public] = request.number
        _check_time(request, here.up)
        return self._by(request, name, key)

    def _key(self, public: str) -> tuple[str, Key]:
        for name, key in self._keys().items():
            if key.public == public:
                return name, key
        raise CommandRefused(sentence('unknown_key', key=f'{public!r:.50}'))

    def _by(self, request: Sealed, name: str, key: Key) -> By:
        sent, signed = (request.origin, request.reason), Signed(name, key.public, request.number)
        if not key.door:
            known = Known.SIGNED_PANEL if name in self._panels() else Known.SIGNED
            return By(name, *sent, key.role, known, '', signed)
        kind = DOOR_KINDS[key.door]
        claims = readable(cut(f'{request.role} ({request.known})', NAME))
        for known in (kind.known, kind.known.at_panel()):
            if request.known == known.value:
                role = _most(key.role, request.role)
                dropped = '' if role.value == request.role else claims
                return By(request.who, *sent, role, known, dropped, signed)
        wanted = {'door': kind.words, 'known': kind.known.value}
        raise CommandRefused(sentence('key_of_door', key=name, **wanted, found=claims))


def _most(allowed: Role, asserted: str) -> Role:
    """Return the role that a door may give its user: not more than it has itself."""
    if asserted == allowed.value:
        return allowed
    if allowed is Role.ENGINEER and asserted in {role.value for role in Role}:
        return Role(asserted)
    return allowed if asserted == Role.ENGINEER.value else Role.VIEW


def _check_time(request: Sealed, up: Uptime) -> None:
    if request.boot != up.boot:
        raise CommandRefused(sentence('signed_before_start'))
    age_s = up.seconds - request.uptime
    if age_s < -ROUNDED_S:
        raise CommandRefused(sentence('signed_ahead', seconds=f'{-age_s:.1f}'))
    if not age_s <= FRESH_S:
        seconds = {'seconds': f'{age_s:.1f}', 'most': f'{FRESH_S:.0f}'}
        raise CommandRefused(sentence('signed_late', **seconds))


def _fits(public: str, text: str, signature: bytes) -> bool:
    demand_library()
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

    try:
        key = Ed25519PublicKey.from_public_bytes(public_key(public))
        key.verify(signature, _PURPOSE + text.encode())
    except (InvalidSignature, ValueError):
        return False
    return True
