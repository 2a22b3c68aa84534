"""argparse that says what was probably meant."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from typing import Any, NoReturn

from bt_orchestrator.script.report import nearest


class CommandParser(argparse.ArgumentParser):
    """A parser whose mistakes name the option or the word that is most like the one found."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{'allow_abbrev': False, **settings})

    def error(self, message: str) -> NoReturn:
        """Print how it is used, the mistake, and what was probably meant; end with 2."""
        found = re.match(r'unrecognized arguments: (--?[\w-]+)', message)
        hint = meant(found[1], self._option_string_actions) if found else ''
        super().error(f'{message}{hint}')

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            known = [str(choice) for choice in action.choices]
            what = f'expected one of {", ".join(known)}; found {value!r}'
            raise argparse.ArgumentError(action, what + meant(str(value), known))


def meant(word: str, known: Iterable[str]) -> str:
    """Return the end of a sentence about a word that is not known; empty: none is like it."""
    near = nearest(word, known)
    return f'; did you mean {near}?' if near else ''
