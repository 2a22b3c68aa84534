"""The option `-o`: where something is written."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from bt_orchestrator.cli.wrong_use import WrongUse


@contextmanager
def opened(path: Path | None) -> Iterator[IO[str]]:
    """Give the file to write to, or the standard output.

    :raises WrongUse: it cannot be written
    """
    if path is None:
        yield sys.stdout
        return
    try:
        file = path.open('w', encoding='utf-8', newline='')
    except OSError as error:
        raise WrongUse(cannot_write(path, error)) from error
    with file:
        yield file


def cannot_write(what: Path | str, error: OSError) -> str:
    """Say what keeps something from being written, and what to do."""
    why = error.strerror or str(error)
    return f'cannot write {what}: {why}; check the path, its permissions and the free space'
