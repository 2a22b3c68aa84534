"""The file of a generated script: whose it is, whether it was edited, and is up to date."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import OrchestratorError, Refused, counted
from bt_orchestrator.cli.output import cannot_write
from bt_orchestrator.extensions.recipes.generating.making import Made, text_digest
from bt_orchestrator.model.script import MadeFrom
from bt_orchestrator.script.fields import file_fields
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.script_file import read_origin
from bt_orchestrator.script.script_keys import SCRIPT
from bt_orchestrator.script.source_text import read_text


class NotReplaced(OrchestratorError):
    """A file is left alone: somebody wrote it, or edited it, or it cannot be written."""


class Standing(NamedTuple):
    """A script file that is there."""

    path: Path
    text: str
    made_from: MadeFrom | None
    """None: somebody wrote it."""

    @property
    def was_edited(self) -> bool:
        """Tell whether it is not as it was generated."""
        return self.made_from is not None and self.made_from.text_digest != text_digest(self.text)

    def diff(self, made: Made) -> list[str]:
        """Return what generating it anew would change, as `diff -u` shows it."""
        old, new, name = self.text.splitlines(), made.text.splitlines(), str(self.path)
        return [*difflib.unified_diff(old, new, name, f'{name}, generated anew', lineterm='')]

    def differing(self, made: Made) -> str:
        """Return how many lines generating it anew would change, in words."""
        _, _, *lines = self.diff(made) or ('', '')
        signs = [line[0] for line in lines]
        number = max(signs.count('+'), signs.count('-'))
        return f'{counted(number, "line")} {"differs" if number == 1 else "differ"}'


def standing(path: Path) -> Standing:
    """Read the text and the origin of a script file.

    :raises Refused: there is none, or it is no script
    """
    text = read_text(path)
    fields = file_fields(text, SCRIPT, Report(str(path)))
    return Standing(path, text, read_origin(fields))


def fault_of(file: Standing, made: Made) -> str | None:
    """Say why a file is not what would be generated now; None: it is."""
    before, now = file.made_from, made.made_from
    if before is None:
        return f'{file.path} was not generated: it has no key `made_from`'
    if file.was_edited:
        return _edited(file, made)
    changes = [*_changes(before, now)]
    if before.text_digest != now.text_digest:
        changes = changes or [*_program(before, now)] or ['other options (--without, --keep)']
    if changes:
        return f'{file.path} is out of date: {", ".join(changes)}; {file.differing(made)}'
    return None


def replace_file(path: Path, made: Made) -> None:
    """Write a script where none is, or one that was generated and never edited.

    :raises NotReplaced: what is there stays
    """
    if path.exists():
        _check_replaceable(path, made)
    beside = path.with_name(f'.{path.name}.part')
    try:
        beside.write_text(made.text, encoding='utf-8')
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise NotReplaced(cannot_write(path, error)) from error


def _check_replaceable(path: Path, made: Made) -> None:
    try:
        file = standing(path)
    except Refused as refused:
        raise NotReplaced(f'{path} is there and is no script; give another -o') from refused
    if file.made_from is None:
        raise NotReplaced(f'{path} is there and was not generated; give another -o')
    if file.was_edited:
        raise NotReplaced(_edited(file, made))


def _edited(file: Standing, made: Made) -> str:
    """Say that a file was edited; how much is known only if nothing else changed since."""
    assert file.made_from is not None
    is_all = not [*_changes(file.made_from, made.made_from)]
    how_much = f' ({file.differing(made)})' if is_all else ''
    remedy = 'put them into overrides, or give another -o'
    return f'{file.path} was edited by hand{how_much}; {remedy}'


def _changes(before: MadeFrom, now: MadeFrom) -> Iterator[str]:
    """Yield what is not as it was when a script was generated."""
    if before.recipe != now.recipe:
        yield f'it is of the recipe {before.recipe}'
    elif before.version != now.version:
        yield f'it is of version {before.version} of the recipe'
    elif before.recipe_digest != now.recipe_digest:
        yield f'the recipe changed, and still calls itself version {now.version}'
    if before.cell_digest != now.cell_digest:
        yield 'the cell changed'
    if before.overrides_digest != now.overrides_digest:
        yield 'the overrides changed'


def _program(before: MadeFrom, now: MadeFrom) -> Iterator[str]:
    if before.generator != now.generator:
        yield f'it was generated by version {before.generator} of the program'
