"""The declarations of a script for its orders: read without its cell, and without a proof."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bt_orchestrator.model.script import Parameter
from bt_orchestrator.script.drafts import ScriptDraft
from bt_orchestrator.script.fields import file_fields
from bt_orchestrator.script.parameters import read_parameters
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.script_keys import SCRIPT
from bt_orchestrator.script.source_text import ENDINGS, read_text


@dataclass(frozen=True)
class Declared:
    """The head of a script."""

    name: str
    """By which an order names it: that of its file, without its ending."""
    params: Mapping[str, Parameter]
    quantity: int | None
    """Default for orders that name none."""


def declared(path: Path) -> Declared:
    """Read the head of a script.

    :raises Refused: it is no script, or there is a mistake in what is read
    """
    report = Report(str(path))
    fields = file_fields(read_text(path), SCRIPT, report)
    draft = ScriptDraft(fields)
    read_parameters(draft, report)
    quantity = fields.optional_whole('quantity')
    report.refuse()
    return Declared(path.stem, draft.params, quantity)


def script_files(folders: Sequence[Path]) -> Iterator[Path]:
    """Yield the files in which a script is looked up by name: the first of each name."""
    found: set[str] = set()
    for folder in folders:
        for path in sorted(_files(folder)):
            if path.stem not in found:
                found.add(path.stem)
                yield path


def _files(folder: Path) -> Iterator[Path]:
    try:
        yield from (path for path in folder.iterdir() if path.suffix == ENDINGS[0])
    except OSError:
        return
