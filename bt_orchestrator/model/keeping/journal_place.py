"""The place of a journal: a file, or the tables of a cell in a database."""

from __future__ import annotations

import re
from argparse import ArgumentTypeError
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError

_ADDRESS = re.compile(r'(?i)postgres(ql)?://')
_PASSWORD = re.compile(r'(?i)//[^/?#@]*:[^/?#@]+@|[?&]password=')


class Address(str):
    """The address of a cell's tables: `postgresql://USER@HOST/DATABASE/CELL`."""

    __slots__ = ()


JournalPlace = Path | Address
"""A journal file, or an address."""


class PasswordShown(OrchestratorError, ArgumentTypeError):
    """An address has a password in it."""


def journal_place(text: str) -> JournalPlace:
    """Return the place that a user names.

    :raises PasswordShown: it has a password, which others would see
    """
    if not _ADDRESS.match(text):
        return Path(text)
    if _PASSWORD.search(text):
        raise PasswordShown(
            'expected an address without a password: others see it in the list of processes and '
            'among the parameters of the node. Put it into ~/.pgpass, for its owner alone'
        )
    return Address(text)
