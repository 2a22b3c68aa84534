"""The words that call this program again, in the shell and folder it was called in."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path

from bt_orchestrator.view.screen.advice import PROGRAM

WRAPPER = 'BT_ORCHESTRATOR_CALLED_AS'
"""Variable in which a script that calls a verb says how it was called itself."""


def called_as() -> str:
    """Return the words for this program that work where the reader stands."""
    program = Path(sys.argv[0])
    if program.name != PROGRAM:  # python -m
        program = Path(sys.executable).with_name(PROGRAM)
    if not program.exists():
        return f'{shlex.quote(sys.executable)} -m bt_orchestrator'
    found = shutil.which(PROGRAM)
    if found is not None and Path(found).samefile(program):
        return PROGRAM
    path = program.absolute()
    here = Path.cwd()
    return shlex.quote(str(path.relative_to(here) if path.is_relative_to(here) else path))


def verb_as(verb: str) -> str:
    """Return the words for a verb; those of the script that called it, if one did."""
    return os.environ.get(WRAPPER) or f'{called_as()} {verb}'
