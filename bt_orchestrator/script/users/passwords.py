"""Passwords as scrypt hashes, each with the parameters that it was made with."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import unicodedata
from dataclasses import dataclass

SHORTEST = 8
"""Characters of a password, at least."""

LONGEST = 200
"""Characters of a password, at most: hashing takes time that grows with it."""

_SALT, _LENGTH = 16, 32
"""Bytes."""


class BadPassword(ValueError):
    """A password that is too short or too long; says what was expected."""


@dataclass(frozen=True)
class Cost:
    """The price of one guess: about 32 MB of memory, three times, and 0.2 s."""

    n: int = 2**15
    r: int = 8
    p: int = 3

    @property
    def is_sane(self) -> bool:
        """Tell whether a computer can bear it, and a guess is not for nothing."""
        is_power = self.n > 1 and self.n & (self.n - 1) == 0
        return is_power and self.memory <= 2**30 and 1 <= self.p <= 16 and self.r >= 1

    @property
    def memory(self) -> int:
        """Bytes that it takes at a time."""
        return 128 * self.n * self.r


@dataclass(frozen=True)
class Hashed:
    """The kept form of a password."""

    salt: bytes
    digest: bytes
    cost: Cost = Cost()

    def matches(self, password: str) -> bool:
        """Tell whether this is the password, in the same time whatever differs."""
        return hmac.compare_digest(_digest(password, self.salt, self.cost), self.digest)


def check(password: str) -> None:
    """Refuse what cannot be a password.

    :raises BadPassword: it is too short or too long
    """
    if not SHORTEST <= len(password) <= LONGEST:
        raise BadPassword(
            f'a password has {SHORTEST} to {LONGEST} characters; found {len(password)}'
        )


def hashed(password: str, cost: Cost | None = None) -> Hashed:
    """Return what is to be kept of a new password.

    :raises BadPassword: it is too short or too long
    """
    check(password)
    salt, cost = secrets.token_bytes(_SALT), cost or Cost()
    return Hashed(salt, _digest(password, salt, cost), cost)


NOBODYS = Hashed(bytes(_SALT), bytes(_LENGTH))
"""Compared with where there is no such user: a refusal takes as long as another one."""


def _digest(password: str, salt: bytes, cost: Cost) -> bytes:
    # Keyboards and systems write one character in several ways.
    text = unicodedata.normalize('NFC', password[: LONGEST + 1]).encode('utf-8', 'surrogatepass')
    return hashlib.scrypt(
        text,
        salt=salt,
        n=cost.n,
        r=cost.r,
        p=cost.p,
        maxmem=cost.memory + 128 * cost.r * cost.p + 2**20,
        dklen=_LENGTH,
    )
