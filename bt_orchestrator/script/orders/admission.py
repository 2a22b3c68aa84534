"""The final check of a script without mistakes: whether it may run (semantics 8.2)."""

from __future__ import annotations

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.deadlock import deadlock
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import START, Place, Report
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar


def admitted(text: str, file: str, cell: Cell, types: ActionTypes) -> Script:
    """Read the text of a script that may run; the file's name stands in the findings.

    :raises Refused: with every mistake in it, or because the line would get stuck; the place is
        the declaration of the circle's flag
    """
    script = parse_script(text, file, cell, types)
    problem = deadlock(script)
    if problem is not None:
        report = Report(file)
        report.add(flag_place(text, problem.flags), str(problem), problem.hint)
        report.refuse()
    return script


def flag_place(text: str, flags: tuple[str, ...]) -> Place:
    """Return where the first of some flags is declared in a script's text."""
    root = compose(text, Report(''))
    listed = root.find('lateral_dependencies') if isinstance(root, MapNode) else None
    items = listed.value.items if listed and isinstance(listed.value, ListNode) else ()
    return next((item.place for item in items if _flag_of(item) in flags), START)


def _flag_of(item: Node) -> str | None:
    entry = item.find('flag') if isinstance(item, MapNode) else None
    return entry.value.text if entry and isinstance(entry.value, Scalar) else None
