"""Reads a journal with every verb that reads, again and again, until it is killed.

    python -m bench.reader JOURNAL CELL

With `-` in place of both it computes without reading anything.
"""

from __future__ import annotations

import itertools
import os
import sys
from contextlib import redirect_stdout
from pathlib import Path

from bt_orchestrator.cli.main import main as verb


def main(journal: str, cell: str) -> None:
    """Go through the verbs; a new line says that it begins."""
    of = ('--journal', journal)
    readings = (
        ('report', *of, '--cell', cell, '--json'),
        ('events', *of, '--format', 'csv'),
        ('history', *of, '--items', '--json'),
        ('report', *of, '--cell', cell, '--durations'),
        ('events', *of, '--format', 'xes'),
    )
    print('begins', flush=True)
    with Path(os.devnull).open('w', encoding='utf-8') as nowhere, redirect_stdout(nowhere):
        for words in itertools.cycle(readings):
            if verb(words):
                sys.exit(f'{" ".join(words)} failed')


def compute() -> None:
    """Use a core."""
    print('begins', flush=True)
    for number in itertools.count():
        str(number)


if __name__ == '__main__':
    compute() if sys.argv[1:] == ['-'] else main(*sys.argv[1:])
