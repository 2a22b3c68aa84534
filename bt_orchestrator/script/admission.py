"""The last question about a script that has no mistakes: whether it may run (semantics 8.2)."""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.model.script import Script
from bt_orchestrator.proof.deadlock import deadlock
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import START, Place, Report
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar


def admit(path: Path, script: Script) -> None:
    """Let a script pass, or refuse it where the flag of the circle is declared.

    :raises Refused: the line would get stuck
    """
    found = deadlock(script)
    if found is None:
        return
    report = Report(str(path))
    place = flag_place(read_text(path), found.flags)
    report.add(place, str(found), found.hint)
    report.refuse()


def flag_place(text: str, flags: tuple[str, ...]) -> Place:
    """Return where the first of some flags is declared in a script's text."""
    root = compose(text, Report(''))
    listed = root.find('lateral_dependencies') if isinstance(root, MapNode) else None
    items = listed.value.items if listed and isinstance(listed.value, ListNode) else ()
    return next((item.place for item in items if _flag_of(item) in flags), START)


def _flag_of(item: Node) -> str | None:
    entry = item.find('flag') if isinstance(item, MapNode) else None
    return entry.value.text if entry and isinstance(entry.value, Scalar) else None
