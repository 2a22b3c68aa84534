"""Telling a user's cell file from a script, by what is in it."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.script.cell_keys import CELL
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import START, Report
from bt_orchestrator.script.script_keys import SCRIPT
from bt_orchestrator.script.shape import refuse_strangers
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import MapNode


class FileKind(Enum):
    """The subject of a file."""

    CELL = 'cell'
    SCRIPT = 'script'


def file_kind(path: Path) -> FileKind:
    """Tell what a file describes; its mistakes are reported by its reader.

    :raises Refused: it cannot be read, or describes neither
    """
    report = Report(str(path))
    text = read_text(path)
    root = compose(text, report)
    refuse_strangers(text, root, report, [CELL, SCRIPT], 'a cell file or a script')
    report.refuse()
    keys = {entry.key.text for entry in root.entries} if isinstance(root, MapNode) else set()
    if keys & {'conveyor', 'components'}:
        return FileKind.CELL
    if 'sections' in keys:
        return FileKind.SCRIPT
    what = 'this is neither a cell file nor a script'
    hint = 'a cell file has the keys `conveyor` and `components`, a script has `sections`'
    raise Refused([Finding(str(path), START.line, START.column, what, hint)])
