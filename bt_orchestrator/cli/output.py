"""Where a verb writes, and how it tells mistakes of a command line or a file."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from bt_orchestrator.base.errors import OrchestratorError, Refused, counted


class WrongUse(OrchestratorError):
    """Options that cannot be carried out; the program ends with 2, as for those argparse finds."""


# Printing the mistakes of a file that was refused.

MOST_ON_TERMINAL = 50
"""Mistakes that a person is shown at once; a file or a pipe gets all of them."""


def print_mistakes(refused: Refused) -> None:
    """Print mistakes on the standard error, in the order of the file."""
    findings = refused.findings
    most = MOST_ON_TERMINAL if sys.stderr.isatty() else len(findings)
    for finding in findings[:most]:
        print(finding, file=sys.stderr)
    if len(findings) > most:
        rest = counted(len(findings) - most, 'more mistake')
        print(f'... and {rest}; check --json has all of them', file=sys.stderr)


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
